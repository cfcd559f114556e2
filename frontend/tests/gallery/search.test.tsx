// What a search was taken for, the size of a work, and how a table was read, as the pages tell them.

import { render } from "preact";
import { describe, expect, it } from "vitest";
import { SearchMeanings } from "../../src/gallery/WorkList";
import { JobProgress } from "../../src/gallery/JobProgress";
import { WorkFacts } from "../../src/gallery/WorkFacts";
import { language } from "../../src/i18n";
import type { Bilingual, Job, Understood, ViewerFacts } from "../../src/types";

const shown = (what: preact.ComponentChild): HTMLElement => {
  const box = document.createElement("div");
  render(what, box);
  return box;
};
const texts = (box: HTMLElement, selector: string): string[] => [...box.querySelectorAll(selector)].map((one) => one.textContent ?? "");

describe("what a search was taken for", () => {
  const understood: Understood[] = [
    { word: "永", meaning: "character", works: 9 },
    { word: "永", meaning: "title", works: 1000 },
    { word: "wang xizhi", meaning: "hand", works: 1 },
  ];

  it("stands once for each word, the nearest meaning first, in the reader's language", () => {
    language.value = "zh";
    expect(texts(shown(<SearchMeanings understood={understood} />), "dt")).toEqual(["永", "wang xizhi"]);
    expect(texts(shown(<SearchMeanings understood={understood} />), "dd")).toEqual(["作為字，9 件 · 作為作品名，1,000 件", "作為書家，1 件"]);
    language.value = "en";
    expect(texts(shown(<SearchMeanings understood={understood} />), "dd")).toEqual(["as the character (9) · as a title (1,000)", "as the hand (1)"]);
  });

  it("is left out when nothing is searched", () => {
    expect(shown(<SearchMeanings understood={[]} />).innerHTML).toBe("");
  });

  it("has a name for every meaning in both languages", () => {
    const meanings = ["character", "form", "reading", "other_reading", "hand", "title", "script", "dynasty", "other"] as const;
    for (const now of ["zh", "en"] as const) {
      language.value = now;
      const names = texts(shown(<SearchMeanings understood={meanings.map((meaning) => ({ word: meaning, meaning, works: 2 }))} />), "dd");
      expect(new Set(names).size).toBe(meanings.length);
      for (const name of names) expect(name).toMatch(now === "zh" ? /^[^a-z]+，2 件$/ : /^[ -~]+ \(2\)$/);
    }
  });
});

describe("the size of a work", () => {
  const none: Bilingual = { zh: "", en: "" };
  const work = {
    title: none, hand: none, period: none, material: none, collection_title: none,
    dynasty: "", script: "", source: "", licence: "CC0-1.0", attribution: "", collection: "a", width: 6000, height: 4000,
  };
  const facts = (more: Partial<ViewerFacts>) => ({ source: "inflation", source_text: none, unit: "px", spacing: 1, width: 1024, height: 683, ...more }) as ViewerFacts;
  const sizes = (more: Partial<ViewerFacts>, own = work) => texts(shown(<WorkFacts work={own} facts={facts(more)} />), ".size");

  it("is the work's own; that of smaller maps is told beside it", () => {
    language.value = "en";
    expect(sizes({})).toEqual(["6000 × 4000 px", "shown here at 1024 × 683"]);
    language.value = "zh";
    expect(sizes({})).toEqual(["6000 × 4000 px", "此處顯示為 1024 × 683"]);
  });

  it("is drawn whole from tiles, but for the view in depth", () => {
    const tiles = { albedo: "iiif/tiles/albedo/a", normals: null, version: "1" };
    language.value = "en";
    expect(sizes({ tiles })).toEqual(["6000 × 4000 px", "3-D view from afar at 1024 × 683"]);
    language.value = "zh";
    expect(sizes({ tiles })).toEqual(["6000 × 4000 px", "從遠處立體檢視為 1024 × 683"]);
  });

  it("is told once where the maps are as large", () => {
    expect(sizes({ width: 300, height: 200 }, { ...work, width: 300, height: 200 })).toEqual(["300 × 200 px"]);
  });

  it("is in millimetres, too, where a pixel has a size", () => {
    language.value = "en";
    expect(sizes({ unit: "mm", spacing: 0.1 })).toEqual(["102.4 mm × 68.3 mm", "6000 × 4000 px", "shown here at 1024 × 683"]);
  });
});

describe("an import that has ended", () => {
  const job = (result: Record<string, unknown>): Job => ({ id: "a", kind: "import", state: "done", done: 2, total: 2, message: "", result, error: null });

  it("tells how the table was read", () => {
    const read_as = { zh: "GB 18030，以分號分隔", en: "GB 18030, cells separated by semicolons" };
    language.value = "zh";
    expect(texts(shown(<JobProgress job={job({ added: 2, there: 0, read_as })} />), ".note")).toEqual(["labels.csv 的讀法：GB 18030，以分號分隔。"]);
    language.value = "en";
    expect(texts(shown(<JobProgress job={job({ added: 2, there: 0, read_as })} />), ".note")).toEqual(["How labels.csv was read: GB 18030, cells separated by semicolons."]);
    expect(texts(shown(<JobProgress job={job({ added: 2, there: 0, read_as: null })} />), ".note")).toEqual([]);
  });
});
