import { describe, expect, it } from "vitest";
import { brushStamps, footprint, fromPressure, fromSpeed, limitSlope, mergeRepeated, penTilt, resample } from "../../src/studio/ink/brush";
import { hasPressure, parseStrokes, type Sample, serializeStrokes, type Stroke } from "../../src/studio/ink/strokes";

/** A straight stroke to the right; pressure as a function of the fraction of its length; speed in cells per second. */
function line(pressure: (u: number) => number, speed = 0.8, hand: Stroke["hand"] = "pen"): Stroke {
  const points = Array.from({ length: 41 }, (_, k): Sample => {
    const u = k / 40;
    return [0.2 + 0.6 * u, 0.5, (600 * u) / speed, pressure(u), 0, 0];
  });
  return { hand, size: 0.04, ink: 0.5, points };
}
/** Half the height that the stamps cover near x. */
const halfAt = (stroke: Stroke, x: number) =>
  Math.max(...brushStamps(stroke).filter((s) => Math.abs(s.x - x) < 0.01).map((s) => s.b));

describe("force", () => {
  it("grows with pressure", () => {
    const even = [0.1, 0.3, 0.6, 1].map(fromPressure);
    expect([...even].sort((a, b) => a - b)).toEqual(even);
    const stroke = line((u) => 0.15 + 0.8 * u);
    expect(halfAt(stroke, 0.68)).toBeGreaterThan(1.5 * halfAt(stroke, 0.32));
  });
  it("falls with speed without a pressure sensor", () => {
    expect(fromSpeed(0.1)).toBeGreaterThan(fromSpeed(1));
    expect(fromSpeed(1)).toBeGreaterThan(fromSpeed(6));
    const [slow, fast] = [line(() => 0.5, 0.2, "mouse"), line(() => 0.5, 5, "mouse")];
    expect(halfAt(slow, 0.45)).toBeGreaterThan(1.3 * halfAt(fast, 0.45));
  });
  it("never exceeds the brush, apart from the spread of wet ink", () => {
    for (const ink of [0, 0.5, 1])
      for (const { a } of brushStamps({ ...line(() => 1), ink })) expect(a).toBeLessThan(0.04 * 1.13);
  });
  it("changes no faster than the limit", () => {
    const places = Array.from({ length: 9 }, (_, k) => ({ s: k }));
    expect(limitSlope([0, 0, 0, 0, 9, 0, 0, 0, 0], places, 1)).toEqual([0, 0, 0, 0, 1, 0, 0, 0, 0]);
    expect(limitSlope([5, 5, 5], places, 1)).toEqual([5, 5, 5]);
  });
});

describe("ends", () => {
  it("are narrower than the middle", () => {
    const stamps = brushStamps(line(() => 0.5, 0.8, "mouse"));
    const middle = stamps[Math.floor(stamps.length / 2)]!.b;
    expect(stamps[0]!.b).toBeLessThan(0.75 * middle);
    expect(stamps.at(-1)!.b).toBeLessThan(0.75 * middle);
  });
  it("are longer points if the brush leaves at speed", () => {
    const reach = (speed: number) => {
      const stamps = brushStamps(line(() => 0.5, speed, "mouse"));
      const middle = stamps[Math.floor(stamps.length / 2)]!.b;
      return 0.8 - stamps.findLast((s) => s.b > 0.8 * middle)!.x;
    };
    expect(reach(4)).toBeGreaterThan(2 * reach(0.2));
  });
  it("stay in place", () => {
    const stamps = brushStamps(line(() => 0.5, 1, "mouse"));
    expect(stamps[0]!.x).toBeCloseTo(0.2, 3);
    expect(stamps.at(-1)!.x).toBeCloseTo(0.8, 3);
  });
});

describe("the path", () => {
  it("goes through its points and does not overshoot a corner", () => {
    const corner: Sample[] = [[0.1, 0.1, 0, 1, 0, 0], [0.5, 0.1, 10, 1, 0, 0], [0.5, 0.5, 20, 1, 0, 0]];
    const way = resample(corner, 0.01);
    for (const [x, y] of corner) expect(Math.min(...way.map((p) => Math.hypot(p[0] - x, p[1] - y)))).toBeLessThan(1e-9);
    expect(Math.max(...way.map((p) => p[0]))).toBeLessThan(0.56);
  });
  it("has the requested spacing", () => {
    const way = resample([[0, 0, 0, 1, 0, 0], [1, 0, 10, 1, 0, 0]], 0.05);
    const steps = way.slice(1).map((p, k) => p[0] - way[k]![0]);
    expect(Math.max(...steps)).toBeLessThan(0.08);
  });
  it("merges points in one place, with the firmer pressure", () => {
    const once: Sample[] = [[0.5, 0.5, 0, 0.2, 0, 0], [0.5, 0.5, 9, 0.7, 0, 0], [0.5, 0.5, 20, 0.4, 0, 0]];
    expect(mergeRepeated(once)).toEqual([[0.5, 0.5, 20, 0.7, 0, 0]]);
  });
  it("has no gaps: neighbouring stamps overlap", () => {
    const stamps = brushStamps(line((u) => (u < 0.5 ? 0.1 : 1)));
    for (const [k, s] of stamps.slice(1).entries())
      expect(Math.hypot(s.x - stamps[k]!.x, s.y - stamps[k]!.y)).toBeLessThan(s.b + stamps[k]!.b);
  });
});

describe("tilt", () => {
  it("lengthens the stamp along the shaft, the more the larger it is", () => {
    const upright = footprint({ x: 0.5, y: 0.5, tiltX: 0, tiltY: 0 }, 0.04);
    const some = footprint({ x: 0.5, y: 0.5, tiltX: 30, tiltY: 0 }, 0.04);
    const more = footprint({ x: 0.5, y: 0.5, tiltX: 60, tiltY: 0 }, 0.04);
    expect(some.angle).toBeCloseTo(0);
    expect(some.a / some.b).toBeGreaterThan(upright.a / upright.b - 0.2);
    expect(more.a / more.b).toBeGreaterThan(some.a / some.b);
    expect(more.x).toBeGreaterThan(0.5);
  });
  it("gives the direction of the shaft", () => {
    expect(penTilt(0, 45).turn).toBeCloseTo(Math.PI / 2);
    expect(penTilt(45, 0).lean).toBeCloseTo(Math.SQRT1_2);
    expect(penTilt(90, 0).lean).toBeLessThanOrEqual(1);
  });
});

describe("a dot", () => {
  const dot = (ms: number): Stroke => ({ hand: "mouse", size: 0.04, ink: 0.5, points: [[0.5, 0.5, 0, 0.5, 0, 0], [0.5, 0.5, ms, 0.5, 0, 0]] });
  it("leaves ink, more the longer the brush stays", () => {
    const widest = (stroke: Stroke) => Math.max(...brushStamps(stroke).map((s) => s.a));
    expect(widest(dot(20))).toBeGreaterThan(0.015);
    expect(widest(dot(500))).toBeGreaterThan(1.3 * widest(dot(20)));
  });
  it("without points is empty", () => expect(brushStamps({ ...dot(5), points: [] })).toEqual([]));
});

describe("saved strokes", () => {
  it("give the same stamps when they are read", () => {
    const stroke = line((u) => 0.2 + 0.6 * u);
    const again = parseStrokes(JSON.parse(JSON.stringify(serializeStrokes([stroke]))));
    const [before, after] = [brushStamps(stroke), brushStamps(again[0]!)];
    expect(after.length).toBe(before.length);
    for (const [k, s] of after.entries()) expect(Math.hypot(s.x - before[k]!.x, s.b - before[k]!.b)).toBeLessThan(2e-4);
  });
  it("are empty if the data is something else", () => {
    for (const wrong of [null, 3, {}, { strokes: "x" }, { strokes: [null, {}] }]) expect(parseStrokes(wrong)).toEqual([]);
  });
  it("tell a pressure sensor from a constant", () => {
    expect(hasPressure(line(() => 0.5).points)).toBe(false);
    expect(hasPressure(line((u) => u).points)).toBe(true);
  });
});
