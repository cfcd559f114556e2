import { describe, expect, it } from "vitest";
import { flawOf } from "../../src/account/password";
import { bandOf, dots, heightOf, pathOf, type Frame, type Point } from "../../src/studio/chart";
import { copiedTwice } from "../../src/studio/Judge";
import type { Attempt } from "../../src/types";
import type { Stroke } from "../../src/studio/ink/stroke";
import { wayBack } from "../../src/studio/login";
import { formOf } from "../../src/studio/marking";
import { lengthOf, until } from "../../src/studio/Replay";

describe("the curve", () => {
  const frame: Frame = { width: 640, height: 240, left: 34, right: 16, top: 12, bottom: 30 };
  const point = (id: string, score: number | null): Point => ({ id, created: "2026-01-01T00:00:00Z", score, interval: score === null ? null : [score - 10, score + 10] });
  it("leaves out what was refused, and spans the frame", () => {
    const found = dots([point("a", 20), point("b", null), point("c", 60)], frame);
    expect(found.map((dot) => dot.point.id)).toEqual(["a", "c"]);
    expect(found.map((dot) => dot.x)).toEqual([34, 624]);
    expect(found[1]!.y).toBeLessThan(found[0]!.y);
    expect(found[0]!.high).toBeLessThan(found[0]!.low);
    expect(pathOf(found).startsWith("M34.0")).toBe(true);
    expect(bandOf(found).split("L")).toHaveLength(4);
  });
  it("holds one attempt, and none", () => {
    expect(dots([point("a", 50)], frame)[0]!.x).toBeGreaterThan(34);
    expect(bandOf(dots([point("a", 50)], frame))).toBe("");
    expect(pathOf([])).toBe("");
  });
  it("never leaves the scale", () => {
    expect(heightOf(140, frame)).toBe(heightOf(100, frame));
    expect(heightOf(-3, frame)).toBe(heightOf(0, frame));
  });
});

describe("after a login", () => {
  it("one comes back to a page of this place alone", () => {
    expect(wayBack("/studio/regular-shui?task=1")).toBe("/studio/regular-shui?task=1");
    for (const elsewhere of [null, "", "//evil.example", "https://evil.example", "javascript:alert(1)"]) expect(wayBack(elsewhere)).toBe("/");
  });
});

describe("a new password", () => {
  it("is told what is wrong with it", () => {
    expect(flawOf("short", "short")).toBe("short");
    expect(flawOf("x".repeat(201), "x".repeat(201))).toBe("long");
    expect(flawOf("aaaaaaaaaa", "aaaaaaaaaa")).toBe("sameLetter");
    expect(flawOf("Lin Daiyu", "Lin Daiyu", "lin daiyu")).toBe("isName");
    expect(flawOf("four words in a row", "four words in a raw")).toBe("differs");
    expect(flawOf("four words in a row", "four words in a row")).toBeNull();
  });
});

describe("the writing once more", () => {
  const stroke = (ms: number): Stroke => ({ hand: "pen", size: 0.04, ink: 0.5, points: [[0, 0, 0, 1, 0, 0], [0.5, 0, ms / 2, 1, 0, 0], [1, 0, ms, 1, 0, 0]] });
  const strokes = [stroke(400), stroke(200)];
  it("shows what was written by then", () => {
    expect(until(strokes, 0).map((s) => s.points.length)).toEqual([1]);
    expect(until(strokes, 250).map((s) => s.points.length)).toEqual([2]);
    expect(until(strokes, 655).map((s) => s.points.length)).toEqual([3, 1]);
    expect(until(strokes, lengthOf(strokes))).toEqual(strokes);
  });
});

describe("what can be compared", () => {
  it("are masters with two marked copies, each named once", () => {
    const one = (id: string, score: number | null) => ({ work: { id }, mark: { score } }) as Attempt;
    expect(copiedTwice([one("a", 50), one("b", 60), one("a", 40), one("c", null), one("c", 70), one("a", 30)]).map((work) => work.id)).toEqual(["a"]);
    expect(copiedTwice([])).toEqual([]);
  });
});

describe("what is sent", () => {
  const copy = { kind: "pen" as const, picture: new Blob(["x"], { type: "image/png" }), strokes: "{}", grid: "mi" as const };
  it("names the work, keeps only when told, and a task only when there is one", () => {
    const form = formOf(copy, "regular-shui", null, false);
    expect([form.get("work"), form.get("keep"), form.get("grid"), form.has("task")]).toEqual(["regular-shui", "false", "mi", false]);
    expect(formOf(copy, "regular-shui", "t1", true).get("task")).toBe("t1");
    expect(formOf({ kind: "photo", picture: copy.picture, grid: "" }, "w", null, true).has("strokes")).toBe(false);
  });
});
