// The corners of a cell in a photograph: turned, moved, and kept those of a cell.

import { describe, expect, it } from "vitest";
import { type Corners, cornersOf, cornersText, isCell, moveCorner, moveCorners, turnCorners } from "../../src/studio/corners";

const size = { width: 800, height: 600 };
const square = cornersOf({ x: 100, y: 100, side: 200 });

describe("corners of a cell", () => {
  it("are those of a square, clockwise from the upper left", () => {
    expect(square).toEqual([[100, 100], [300, 100], [300, 300], [100, 300]]);
    expect(isCell(square)).toBe(true);
    expect(isCell([...square].reverse() as unknown as Corners)).toBe(false);
  });
  it("turn clockwise about their middle, and back", () => {
    const turned = turnCorners(square, 90);
    turned[0].forEach((value, axis) => expect(value).toBeCloseTo(square[1][axis]!, 6));
    const back = turnCorners(turnCorners(square, 7.5), -7.5);
    back.forEach((corner, k) => corner.forEach((value, axis) => expect(value).toBeCloseTo(square[k]![axis]!, 6)));
    expect(turnCorners(square, 0.5)[0][1]).toBeLessThan(100.9);
    expect(turnCorners(square, 0.5)[1][1]).toBeGreaterThan(100);
  });
  it("move one by one within the picture, and stay convex", () => {
    expect(moveCorner(square, 0, [60, 80], size)[0]).toEqual([60, 80]);
    expect(moveCorner(square, 2, [900, 900], size)[2]).toEqual([800, 600]);
    expect(moveCorner(square, 0, [290, 290], size)).toBe(square); // would fold
    expect(moveCorner(square, 0, [280, 100], size)).toBe(square); // too short
  });
  it("move together as far as the picture goes", () => {
    expect(moveCorners(square, -500, 20, size)).toEqual([[0, 120], [200, 120], [200, 320], [0, 320]]);
    expect(moveCorners(square, 900, 900, size)[2]).toEqual([800, 600]);
  });
  it("are sent to a tenth of a pixel", () => {
    expect(cornersText(turnCorners(square, 3))).toMatch(/^\[\[\d+(\.\d)?,\d+(\.\d)?\],/);
  });
});
