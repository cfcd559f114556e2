// Cells of a sheet as a page shows them.

import { describe, expect, it } from "vitest";
import { lowestOf, rowsOf, sentenceOf, type SheetCell } from "../../src/sheets/upload";

const cell = (row: number, column: number, score: number | null, more: Partial<SheetCell> = {}): SheetCell => ({
  row, column, score, character: "永", polygon: [], level_text: null, refused: null, told: null, is_fault: false, attempt: null, picture: null, ...more,
});

describe("cells of a sheet", () => {
  it("stand in their rows, from the left", () => {
    const rows = rowsOf([cell(2, 1, 50), cell(0, 3, 60), cell(2, 0, 70), cell(0, 1, 80)]);
    expect(rows.map((row) => row.map((one) => [one.row, one.column]))).toEqual([[[0, 1], [0, 3]], [[2, 0], [2, 1]]]);
    expect(rowsOf([])).toEqual([]);
  });
  it("have a lowest mark unless none is marked", () => {
    expect(lowestOf([cell(0, 0, 60), cell(0, 1, null), cell(0, 2, 41), cell(1, 0, 90)])?.column).toBe(2);
    expect(lowestOf([cell(0, 0, null)])).toBeNull();
  });
  it("say why they have no mark rather than a remark", () => {
    const told = { zh: "歪。", en: "Leans." };
    const refused = { code: "blank", zh: "空白。", en: "Blank." };
    expect(sentenceOf(cell(0, 0, null, { told, refused }))).toBe(refused);
    expect(sentenceOf(cell(0, 0, 60, { told }))).toBe(told);
    expect(sentenceOf(cell(0, 0, 99))).toBeNull();
  });
});
