import { describe, expect, it } from "vitest";
import { type Numbered, type NumberFrame, placeNumbers } from "../../src/strokes/numbers";

const FRAME: NumberFrame = { width: 300, height: 300, radius: 12, from: "middle" };
const inUnits = (places: ReturnType<typeof placeNumbers>, frame: NumberFrame) => places.map(({ x, y }) => [x * frame.width, y * frame.height] as const);

/** Whole within the picture, and none over another. */
function expectClear(items: readonly Numbered[], frame: NumberFrame): void {
  const places = inUnits(placeNumbers(items, frame), frame);
  for (const [k, [x, y]] of places.entries()) {
    expect(Math.min(x, y, frame.width - x, frame.height - y)).toBeGreaterThanOrEqual(frame.radius - 1e-6);
    for (const [u, v] of places.slice(k + 1)) expect(Math.hypot(x - u, y - v)).toBeGreaterThanOrEqual(2 * frame.radius);
  }
}

describe("numbers on strokes", () => {
  const across: Numbered = { lines: [[[0.2, 0.4], [0.8, 0.4]]] };
  it("stand in the middle of their stroke, or at its start", () => {
    expect(placeNumbers([across], FRAME)[0]).toEqual({ x: expect.closeTo(0.5), y: expect.closeTo(0.4), tether: null });
    expect(placeNumbers([across], { ...FRAME, from: "start" })[0]).toEqual({ x: expect.closeTo(0.2), y: expect.closeTo(0.4), tether: null });
  });
  it("share a stroke, all on it", () => {
    const places = placeNumbers([across, across, across], FRAME);
    expectClear([across, across, across], FRAME);
    for (const { y, tether } of places) {
      expect(y).toBeCloseTo(0.4);
      expect(tether).toBeNull();
    }
  });
  it("stand beside a stroke that is too short for all of them, tied to it", () => {
    const dot: Numbered = { lines: [[[0.5, 0.5], [0.53, 0.53]]] };
    const places = placeNumbers([dot, dot, dot], FRAME);
    expectClear([dot, dot, dot], FRAME);
    expect(places.filter(({ tether }) => tether === null)).toHaveLength(1);
    for (const { x, y, tether } of places) if (tether) expect(Math.hypot(x - tether[0], y - tether[1]) * 300).toBeLessThan(4 * FRAME.radius);
  });
  it("stay within the picture and clear of each other, on a phone too", () => {
    const corner: Numbered = { lines: [[[0.99, 0.005], [1, 0]]] };
    const whole: Numbered = { lines: [] };
    const boxed: Numbered = { lines: [], box: [0.9, 0, 1, 0.2] };
    const items = [corner, corner, whole, boxed, whole, across, { lines: [[[0.02, 0.99]]] } as Numbered];
    for (const side of [130, 300, 800]) expectClear(items, { ...FRAME, width: side, height: side });
    expectClear(items, { ...FRAME, width: 320, height: 130 });
  });
  it("leave a short stroke to its own number", () => {
    const short: Numbered = { lines: [[[0.48, 0.4], [0.52, 0.4]]] };
    const [first, second] = placeNumbers([across, short], FRAME);
    expect(second!.tether).toBeNull();
    expect(second!.x).toBeCloseTo(0.5);
    expect(first!.tether).toBeNull();
  });
  it("never fail in a picture that is too small for them", () => {
    expect(placeNumbers(Array(9).fill(across), { ...FRAME, width: 30, height: 30 })).toHaveLength(9);
  });
});
