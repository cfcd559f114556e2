import { describe, expect, it } from "vitest";
import { changesOf } from "../../src/gallery/WorkForm";
import { licenceField } from "../../src/gallery/licences";
import type { Work } from "../../src/types";

const work = {
  title: { zh: "楷書「日」", en: "" },
  hand: { zh: "", en: "" },
  period: { zh: "", en: "" },
  material: { zh: "紙本", en: "ink on paper\nmounted" },
  character: "日",
  script: "regular",
  dynasty: "tang",
  source: "a book",
  licence: "none stated",
  attribution: "",
  spacing: 0.25,
} as Work;

function form(values: Record<string, string>): FormData {
  const made = new FormData();
  for (const [name, value] of Object.entries(values)) made.set(name, value);
  return made;
}

describe("the changes that a form sends", () => {
  it("are none if the form was not edited", () => {
    const asItWas = { title_zh: "楷書「日」", title_en: "", material_en: "ink on paper\r\nmounted ", script: "regular", licence: licenceField(work.licence), spacing: "0.25" };
    expect(changesOf(work, form(asItWas))).toEqual({});
  });

  it("include both languages of a text of which one changed", () => {
    expect(changesOf(work, form({ title_zh: "楷書「日」", title_en: "Sun" }))).toEqual({ title: { zh: "楷書「日」", en: "Sun" } });
  });

  it("clear a field that was emptied, the pixel size too", () => {
    expect(changesOf(work, form({ material_zh: "", material_en: "", dynasty: " ", spacing: "" }))).toEqual({ material: { zh: "", en: "" }, dynasty: "", spacing: null });
    expect(changesOf({ ...work, spacing: null }, form({ spacing: "" }))).toEqual({});
    expect(changesOf(work, form({ spacing: "0.5", licence: "CC0-1.0" }))).toEqual({ spacing: 0.5, licence: "CC0-1.0" });
  });
});
