import { describe, expect, it } from "vitest";
import { add, blank, canRedo, canUndo, clear, redo, undo, written } from "../../src/studio/ink/history";
import { admit, openGate, release, sampleOf } from "../../src/studio/ink/pointers";
import type { Stroke } from "../../src/studio/ink/stroke";

const stroke = (x: number): Stroke => ({ hand: "pen", size: 0.04, ink: 0.5, points: [[x, x, 0, 1, 0, 0]] });
const touch = (pointerId: number, pointerType: string, isPrimary = true) => ({ pointerId, pointerType, isPrimary, button: 0 });

describe("undo and redo", () => {
  const two = add(add(blank, stroke(0.1)), stroke(0.2));
  it("go back and forth", () => {
    expect(undo(two).done).toEqual([stroke(0.1)]);
    expect(redo(undo(two)).done).toEqual(two.done);
    expect(canUndo(undo(undo(two)))).toBe(false);
    expect(undo(blank)).toBe(blank);
    expect(redo(two)).toBe(two);
  });
  it("forget what was undone once something new is written", () => {
    expect(canRedo(add(undo(two), stroke(0.3)))).toBe(false);
  });
  it("take a clearing back whole", () => {
    const cleared = clear(two);
    expect(cleared.done).toEqual([]);
    expect(undo(cleared).done).toEqual(two.done);
    expect(canUndo(clear(blank))).toBe(false);
  });
  it("begin from what was kept", () => expect(written([stroke(1)]).done).toHaveLength(1));
});

describe("palms", () => {
  it("write while no pen was seen, with one finger at a time", () => {
    const first = admit(openGate, touch(1, "touch"));
    expect(first.begins).toBe(true);
    expect(admit(first.gate, touch(2, "touch", false)).begins).toBe(false);
    expect(admit(release(first.gate, 1), touch(3, "touch")).begins).toBe(true);
  });
  it("are nothing once a pen was seen", () => {
    const pen = admit(openGate, touch(1, "pen"));
    expect(admit(release(pen.gate, 1), touch(2, "touch")).begins).toBe(false);
    expect(admit(release(pen.gate, 1), touch(3, "pen")).begins).toBe(true);
  });
  it("give way to the first pen that comes after them", () => {
    const palm = admit(openGate, touch(1, "touch"));
    const pen = admit(palm.gate, touch(2, "pen"));
    expect(pen).toMatchObject({ begins: true, takesOver: true });
    expect(pen.gate.active).toBe(2);
    expect(release(pen.gate, 1).active).toBe(2);
  });
  it("leave the mouse its main button alone", () => {
    expect(admit(openGate, { ...touch(1, "mouse"), button: 2 }).begins).toBe(false);
    expect(admit(openGate, touch(1, "mouse")).begins).toBe(true);
  });
});

describe("a sample", () => {
  it("is in fractions of the cell", () => {
    const event = { clientX: 150, clientY: 120, timeStamp: 1016, pressure: 0.7, tiltX: 20, tiltY: -10 };
    expect(sampleOf(event, { left: 100, top: 20, width: 200, height: 200 }, 1000)).toEqual([0.25, 0.5, 16, 0.7, 20, -10]);
  });
});
