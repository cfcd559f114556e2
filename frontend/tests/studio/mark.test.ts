import { describe, expect, it } from "vitest";
import { compose, decompose, fitInSquare, IDENTITY, interpolate, type Matrix, transformPoint } from "../../src/studio/mark/alignment";
import { distanceColour } from "../../src/studio/mark/DistanceOverlay";
import { growSquare, moveSquare, resizeSquare } from "../../src/studio/crop";

const close = (a: readonly number[], b: readonly number[]) => a.forEach((v, k) => expect(v).toBeCloseTo(b[k]!, 9));
const turned = (degrees: number, size: number, e: number, f: number): Matrix => {
  const [c, s] = [Math.cos((degrees * Math.PI) / 180) * size, Math.sin((degrees * Math.PI) / 180) * size];
  return [c, s, -s, c, e, f];
};

describe("the interpolation from as written to aligned", () => {
  const whole = turned(20, 1.44, 0.1, -0.05);
  it("begins with the identity and ends with the whole map", () => {
    close(interpolate(whole, 0, [0.4, 0.6]), IDENTITY);
    close(interpolate(whole, 1, [0.4, 0.6]), whole);
  });
  it("has half of the rotation, the root of the size and half of the shift in the middle", () => {
    const half = interpolate(whole, 0.5, [0.4, 0.6]);
    expect((decompose(half).turn * 180) / Math.PI).toBeCloseTo(10);
    expect(decompose(half).size).toBeCloseTo(1.2);
    const goal = transformPoint(whole, [0.4, 0.6]);
    close(transformPoint(half, [0.4, 0.6]), [(0.4 + goal[0]) / 2, (0.6 + goal[1]) / 2]);
  });
  it("includes a stretch, as between pictures of different proportions", () => {
    const stretched = compose([1.3, 0, 0, 0.8, 0.02, 0], turned(-33, 0.9, 0, 0.1));
    close(interpolate(stretched, 1, [0.5, 0.5]), stretched);
  });
});

it("a long picture fits in the square", () => {
  const place = fitInSquare(200, 400);
  close(transformPoint(place, [0, 0]), [0.25, 0]);
  close(transformPoint(place, [1, 1]), [0.75, 1]);
});

describe("colours of distance", () => {
  it("get darker with distance", () => {
    const light = ([r, g, b]: readonly [number, number, number]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
    const all = Array.from({ length: 21 }, (_, k) => light(distanceColour(k / 20)));
    for (const [k, value] of all.slice(2).entries()) expect(value).toBeLessThan(all[k]! + 10);
    expect(all[0]! - all[20]!).toBeGreaterThan(80);
  });
  it("are clamped", () => {
    expect(distanceColour(7)).toEqual(distanceColour(1));
    expect(distanceColour(-1)).toEqual(distanceColour(0));
  });
});

describe("the square of a photograph", () => {
  const size = { width: 400, height: 300 };
  it("stays within the picture when it is dragged", () => {
    expect(moveSquare({ x: 50, y: 50, side: 200 }, 900, -900, size)).toEqual({ x: 200, y: 0, side: 200 });
  });
  it("keeps the opposite corner and stays square", () => {
    expect(resizeSquare({ x: 100, y: 100, side: 100 }, "se", 260, 230, size)).toEqual({ x: 100, y: 100, side: 160 });
    expect(resizeSquare({ x: 100, y: 100, side: 100 }, "nw", 40, 90, size)).toEqual({ x: 40, y: 40, side: 160 });
    expect(resizeSquare({ x: 100, y: 100, side: 100 }, "ne", 999, -999, size)).toEqual({ x: 100, y: 0, side: 200 });
    expect(resizeSquare({ x: 100, y: 100, side: 100 }, "se", 0, 0, size).side).toBe(32);
  });
  it("grows about its middle up to the edges", () => {
    expect(growSquare({ x: 100, y: 100, side: 100 }, 20, size)).toEqual({ x: 90, y: 90, side: 120 });
    expect(growSquare({ x: 0, y: 0, side: 100 }, 999, size)).toEqual({ x: 0, y: 0, side: 300 });
  });
});
