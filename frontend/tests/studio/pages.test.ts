import { describe, expect, it } from "vitest";
import { passwordProblem } from "../../src/account/NewPassword";
import { chartDots, type ChartFrame, intervalBand, linePath, type ScorePoint, scoreY } from "../../src/studio/MarksChart";
import { worksToCompare } from "../../src/studio/ComparePage";
import type { Attempt } from "../../src/types";
import type { Stroke } from "../../src/studio/ink/strokes";
import { returnPath } from "../../src/account/RequireLogin";
import { firstTask } from "../../src/account/JoinPage";
import { markForm } from "../../src/studio/marking";
import { replayDuration, strokesUntil } from "../../src/studio/Replay";

describe("the chart of marks", () => {
  const frame: ChartFrame = { width: 640, height: 240, left: 34, right: 16, top: 12, bottom: 30 };
  const point = (id: string, score: number | null): ScorePoint => ({ id, created: "2026-01-01T00:00:00Z", score, interval: score === null ? null : [score - 10, score + 10] });
  it("omits refused attempts and spans the frame", () => {
    const found = chartDots([point("a", 20), point("b", null), point("c", 60)], frame);
    expect(found.map((dot) => dot.point.id)).toEqual(["a", "c"]);
    expect(found.map((dot) => dot.x)).toEqual([34, 624]);
    expect(found[1]!.y).toBeLessThan(found[0]!.y);
    expect(found[0]!.high).toBeLessThan(found[0]!.low);
    expect(linePath(found).startsWith("M34.0")).toBe(true);
    expect(intervalBand(found).split("L")).toHaveLength(4);
  });
  it("works with one attempt and with none", () => {
    expect(chartDots([point("a", 50)], frame)[0]!.x).toBeGreaterThan(34);
    expect(intervalBand(chartDots([point("a", 50)], frame))).toBe("");
    expect(linePath([])).toBe("");
  });
  it("clamps to the scale", () => {
    expect(scoreY(140, frame)).toBe(scoreY(100, frame));
    expect(scoreY(-3, frame)).toBe(scoreY(0, frame));
  });
});

describe("after a login", () => {
  it("only a page of this site is opened", () => {
    expect(returnPath("/studio/regular-shui?task=1")).toBe("/studio/regular-shui?task=1");
    for (const elsewhere of [null, "", "//evil.example", "https://evil.example", "javascript:alert(1)"]) expect(returnPath(elsewhere)).toBe("/");
  });
});

describe("a new password", () => {
  it("is refused with a reason", () => {
    expect(passwordProblem("short", "short")).toBe("short");
    expect(passwordProblem("x".repeat(201), "x".repeat(201))).toBe("long");
    expect(passwordProblem("aaaaaaaaaa", "aaaaaaaaaa")).toBe("sameLetter");
    expect(passwordProblem("Lin Daiyu", "Lin Daiyu", "lin daiyu")).toBe("isName");
    expect(passwordProblem("four words in a row", "four words in a raw")).toBe("differs");
    expect(passwordProblem("four words in a row", "four words in a row")).toBeNull();
  });
});

describe("a replay", () => {
  const stroke = (ms: number): Stroke => ({ hand: "pen", size: 0.04, ink: 0.5, points: [[0, 0, 0, 1, 0, 0], [0.5, 0, ms / 2, 1, 0, 0], [1, 0, ms, 1, 0, 0]] });
  const strokes = [stroke(400), stroke(200)];
  it("shows what had been written at a time", () => {
    expect(strokesUntil(strokes, 0).map((s) => s.points.length)).toEqual([1]);
    expect(strokesUntil(strokes, 250).map((s) => s.points.length)).toEqual([2]);
    expect(strokesUntil(strokes, 655).map((s) => s.points.length)).toEqual([3, 1]);
    expect(strokesUntil(strokes, replayDuration(strokes))).toEqual(strokes);
  });
});

describe("a pupil who has joined a class", () => {
  it("begins with the newest task that is not over", () => {
    const now = new Date("2026-03-01T12:00:00Z");
    const [over, open, always] = [{ id: "a", due: "2026-02-28T16:00:00Z" }, { id: "b", due: "2026-03-02T16:00:00Z" }, { id: "c", due: null }];
    expect([[over, open, always], [over, always], [over], []].map((tasks) => firstTask(tasks, now))).toEqual(["/tasks/b", "/tasks/c", null, null]);
  });
});

describe("works to compare", () => {
  it("have at least two marked copies, and are listed once", () => {
    const one = (id: string, score: number | null) => ({ work: { id, character: id === "d" ? "" : "水" }, mark: { score } }) as Attempt;
    expect(worksToCompare([one("a", 50), one("b", 60), one("a", 40), one("c", null), one("c", 70), one("a", 30), one("d", 50), one("d", 60)]).map((work) => work.id)).toEqual(["a"]);
    expect(worksToCompare([])).toEqual([]);
  });
});

describe("the form of a copy", () => {
  const copy = { kind: "pen" as const, picture: new Blob(["x"], { type: "image/png" }), strokes: "{}", grid: "mi" as const };
  it("has the work, whether to save, and the task if there is one", () => {
    const form = markForm(copy, "regular-shui", null, { keep: false, unmarked: false });
    expect([form.get("work"), form.get("keep"), form.get("keep_unmarked"), form.get("grid"), form.has("task")]).toEqual(["regular-shui", "false", "false", "mi", false]);
    expect(markForm(copy, "regular-shui", "t1", { keep: true, unmarked: true }).get("task")).toBe("t1");
    expect(markForm({ kind: "photo", picture: copy.picture, grid: "" }, "w", null, { keep: true, unmarked: false }).has("strokes")).toBe(false);
  });
});
