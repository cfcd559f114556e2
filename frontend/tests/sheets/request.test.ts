import { describe, expect, it } from "vitest";
import { isAsked, readRequest, requestQuery, sheetUrl, USUAL } from "../../src/sheets/request";

describe("a sheet as it is asked for", () => {
  it("stands in the address of the page, and comes back from it", () => {
    const asked = { ...USUAL, text: "永天 人", works: ["regular-shui", "seal-tian"], grid: "hui", model: "shrinking", paper: "Letter", cell: 40, times: 3, strokes: false, pupil: "王小明", class: "c1", master: "seal" } as const;
    expect(readRequest(new URLSearchParams(requestQuery({ ...asked, works: [...asked.works] }).toString()))).toEqual(asked);
    expect(requestQuery(USUAL).toString()).toBe("");
    expect(readRequest(new URLSearchParams())).toEqual(USUAL);
  });
  it("takes what is wrong in an address as usual", () => {
    const read = readRequest(new URLSearchParams("grid=square&model=x&cell=9999&times=-3&master=../etc&paper=A3&cell2=1"));
    expect(read).toEqual({ ...USUAL, cell: 80, times: 0 });
    expect(readRequest(new URLSearchParams("cell=abc&pupil=" + "王".repeat(40)))).toEqual({ ...USUAL, pupil: "王".repeat(24) });
  });
  it("is a question to the service", () => {
    const asked = { ...USUAL, text: "水", works: ["a", "b"], class: "c1" };
    expect(sheetUrl(asked, "")).toBe("api/practice-sheet?text=%E6%B0%B4&works=a&works=b");
    expect(sheetUrl(asked, ".png", 2)).toBe("api/practice-sheet.png?text=%E6%B0%B4&works=a&works=b&number=2");
    expect(sheetUrl(asked, ".pdf")).toBe("api/practice-sheet.pdf?text=%E6%B0%B4&works=a&works=b&class=c1");
  });
  it("needs characters or works", () => {
    expect(isAsked(USUAL)).toBe(false);
    expect(isAsked({ ...USUAL, text: "  " })).toBe(false);
    expect(isAsked({ ...USUAL, text: "水" }) && isAsked({ ...USUAL, works: ["a"] })).toBe(true);
  });
});
