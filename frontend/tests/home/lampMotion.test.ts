import { describe, expect, it } from "vitest";
import { circling, hasCircled, pointed, tilted } from "../../src/home/lampMotion";

const size = { width: 400, height: 300 };

describe("the lamp of the home page", () => {
  it("stands on the pointer's side, lower the farther from the middle", () => {
    expect(pointed(400, 150, size).tilt).toBeCloseTo(0);
    expect(pointed(200, 0, size).tilt).toBeCloseTo(90);
    expect(pointed(0, 150, size).tilt).toBeCloseTo(180);
    expect(pointed(200, 300, size).tilt).toBeCloseTo(270);
    const slants = [200, 250, 300, 400].map((x) => pointed(x, 150, size).slant);
    expect([...slants].sort((a, b) => a - b)).toEqual(slants);
    expect(slants[0]).toBeLessThan(20);
    expect(pointed(4000, -900, size).slant).toBe(pointed(400, 150, size).slant); // never along the sheet
  });
  it("goes where a tilted phone turns up its edge", () => {
    expect(tilted(35, 20).tilt).toBeCloseTo(0); // tilted to the right
    expect(tilted(35, -20).tilt).toBeCloseTo(180);
    expect(tilted(10, 0).tilt).toBeCloseTo(90); // laid flatter
    expect(tilted(60, 0).tilt).toBeCloseTo(270);
    expect(tilted(35, 10).slant).toBeLessThan(tilted(35, 30).slant);
  });
  it("rests when it has been all around, and not before", () => {
    expect([0, 7, 13.9].map(hasCircled)).toEqual([false, false, false]);
    expect([14, 60].map(hasCircled)).toEqual([true, true]);
  });
  it("circles by itself, at one height", () => {
    const turn = Array.from({ length: 28 }, (_, k) => circling(k / 2));
    expect(new Set(turn.map((lamp) => lamp.slant)).size).toBe(1);
    for (const lamp of turn) expect(lamp.tilt >= 0 && lamp.tilt < 360).toBe(true);
    expect(circling(14).tilt).toBeCloseTo(circling(0).tilt);
  });
});
