import { describe, expect, it } from "vitest";
import { changesOf } from "../../src/gallery/WorkForm";
import { licenceField } from "../../src/gallery/labels";
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

describe("what an owner changes of a work", () => {
  it("is nothing when the form is sent as it was", () => {
    const asItWas = { title_zh: "楷書「日」", title_en: "", material_en: "ink on paper\r\nmounted ", script: "regular", licence: licenceField(work.licence), spacing: "0.25" };
    expect(changesOf(work, form(asItWas))).toEqual({});
  });

  it("is a text in both languages when one of them changed", () => {
    expect(changesOf(work, form({ title_zh: "楷書「日」", title_en: "Sun" }))).toEqual({ title: { zh: "楷書「日」", en: "Sun" } });
  });

  it("is taken back when a field is emptied, the size of a pixel too", () => {
    expect(changesOf(work, form({ material_zh: "", material_en: "", dynasty: " ", spacing: "" }))).toEqual({ material: { zh: "", en: "" }, dynasty: "", spacing: null });
    expect(changesOf({ ...work, spacing: null }, form({ spacing: "" }))).toEqual({});
    expect(changesOf(work, form({ spacing: "0.5", licence: "CC0-1.0" }))).toEqual({ spacing: 0.5, licence: "CC0-1.0" });
  });
});
