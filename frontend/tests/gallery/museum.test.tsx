// A museum's words: in the reader's language where there is one, links only where they lead to the web.

import { render } from "preact";
import { describe, expect, it, vi } from "vitest";
import { MuseumFacts, textsFor } from "../../src/gallery/MuseumFacts";
import { FlatWork } from "../../src/gallery/WorkPage";
import { language } from "../../src/i18n";
import type { MuseumRecord, Work } from "../../src/types";

const RECORD: MuseumRecord = {
  label: { en: ["Album"] },
  canvas_label: { none: ["3r"] },
  metadata: [{ label: { en: ["Date"], "zh-Hant": ["年代"] }, value: { en: ["Tang"], "zh-Hant": ["唐"] } }],
  statement: { label: { en: ["Credit"] }, value: { en: ["Gift, see https://example.org/gift"] } },
  provider: [{ en: ["A Museum"] }],
  rights: "http://creativecommons.org/publicdomain/zero/1.0/",
  manifest: "https://example.org/manifest.json",
  canvas: "https://example.org/canvas/3",
  homepage: "javascript:alert(1)",
};

const shown = (record: MuseumRecord | null): HTMLElement => {
  const box = document.createElement("div");
  render(<MuseumFacts record={record} />, box);
  return box;
};

describe("a leaf that no surface can be made of", () => {
  it("is shown as it is, with the reason and the museum's words", async () => {
    language.value = "en";
    const both = (text: string) => ({ zh: text, en: text });
    const work = {
      id: "leaf", title: both("A cover"), hand: both(""), period: both(""), material: both(""), dynasty: "", script: "", width: 30, height: 20, source: "", licence: "CC0-1.0",
      attribution: "", collection: "album", collection_title: both("Album"), character: "", within: null, record: RECORD, previous: "leaf-0", next: null, files: { picture: "p.jpg" },
    } as unknown as Work;
    const box = document.createElement("div");
    render(<FlatWork work={work} reason={{ zh: "沒有字", en: "nothing is written on it" }} retry={() => undefined} />, box);
    await vi.waitFor(() => expect(box.querySelector("img")!.getAttribute("src")).toBe("p.jpg")); // here without WebGL2
    expect(box.querySelector(".work-stage .note")!.textContent).toContain("nothing is written on it");
    expect(box.querySelector("h1")!.textContent).toBe("A cover");
    expect(box.textContent).toContain("30 × 20 px");
    expect(box.querySelector(".museum")).not.toBeNull();
    expect(box.querySelector(".neighbours a")!.getAttribute("href")).toBe("#/works/leaf-0");
  });
});

describe("a museum's words", async () => {
  it("are those of the reader's language, else those without one, else the first", () => {
    language.value = "zh";
    expect(textsFor({ en: ["a"], "zh-Hant": ["甲"] })).toEqual({ lang: "zh-Hant", texts: ["甲"] });
    expect(textsFor({ fr: ["b"], none: ["3r"] })).toEqual({ lang: "", texts: ["3r"] });
    language.value = "en";
    expect(textsFor({ "zh-Hant": ["甲"], "en-GB": ["a"] })).toEqual({ lang: "en-GB", texts: ["a"] });
    expect(textsFor({ fr: ["b"], de: ["c"] })).toEqual({ lang: "fr", texts: ["b"] });
    expect(textsFor({})).toBeNull();
  });

  it("stand with their labels, and link to the web alone", () => {
    language.value = "zh";
    const box = shown(RECORD);
    const facts = [...box.querySelectorAll("dl > div")].map((row) => row.textContent);
    expect(facts).toContain("年代唐");
    expect(facts).toContain("CreditGift, see https://example.org/gift");
    expect(facts).toContain("此頁3r");
    const links = [...box.querySelectorAll("a")].map((one) => one.getAttribute("href"));
    expect(links).toEqual(["https://example.org/gift", RECORD.rights, RECORD.manifest]);
  });

  it("are left out where there are none", () => {
    expect(shown(null).innerHTML).toBe("");
  });
});
