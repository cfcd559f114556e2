import { describe, expect, it } from "vitest";
import { addStroke, canRedo, canUndo, clearStrokes, EMPTY_HISTORY, historyOf, redo, type Stroke, undo } from "../../src/studio/ink/strokes";
import { acceptPointer, NO_POINTER, releasePointer, sampleOf } from "../../src/studio/ink/pointers";

const stroke = (x: number): Stroke => ({ hand: "pen", size: 0.04, ink: 0.5, points: [[x, x, 0, 1, 0, 0]] });
const touch = (pointerId: number, pointerType: string, isPrimary = true) => ({ pointerId, pointerType, isPrimary, button: 0 });

describe("undo and redo", () => {
  const two = addStroke(addStroke(EMPTY_HISTORY, stroke(0.1)), stroke(0.2));
  it("step back and forth", () => {
    expect(undo(two).done).toEqual([stroke(0.1)]);
    expect(redo(undo(two)).done).toEqual(two.done);
    expect(canUndo(undo(undo(two)))).toBe(false);
    expect(undo(EMPTY_HISTORY)).toBe(EMPTY_HISTORY);
    expect(redo(two)).toBe(two);
  });
  it("drop undone strokes when a new one is written", () => {
    expect(canRedo(addStroke(undo(two), stroke(0.3)))).toBe(false);
  });
  it("restore everything that was cleared", () => {
    const cleared = clearStrokes(two);
    expect(cleared.done).toEqual([]);
    expect(undo(cleared).done).toEqual(two.done);
    expect(canUndo(clearStrokes(EMPTY_HISTORY))).toBe(false);
  });
  it("start from saved strokes", () => expect(historyOf([stroke(1)]).done).toHaveLength(1));
});

describe("touches", () => {
  it("write until a pen is used, with one finger at a time", () => {
    const first = acceptPointer(NO_POINTER, touch(1, "touch"));
    expect(first.begins).toBe(true);
    expect(acceptPointer(first.pointers, touch(2, "touch", false)).begins).toBe(false);
    expect(acceptPointer(releasePointer(first.pointers, 1), touch(3, "touch")).begins).toBe(true);
  });
  it("are ignored once a pen has been used", () => {
    const pen = acceptPointer(NO_POINTER, touch(1, "pen"));
    expect(acceptPointer(releasePointer(pen.pointers, 1), touch(2, "touch")).begins).toBe(false);
    expect(acceptPointer(releasePointer(pen.pointers, 1), touch(3, "pen")).begins).toBe(true);
  });
  it("give way to the first pen", () => {
    const palm = acceptPointer(NO_POINTER, touch(1, "touch"));
    const pen = acceptPointer(palm.pointers, touch(2, "pen"));
    expect(pen).toMatchObject({ begins: true, takesOver: true });
    expect(pen.pointers.active).toBe(2);
    expect(releasePointer(pen.pointers, 1).active).toBe(2);
  });
  it("of a mouse write with the main button only", () => {
    expect(acceptPointer(NO_POINTER, { ...touch(1, "mouse"), button: 2 }).begins).toBe(false);
    expect(acceptPointer(NO_POINTER, touch(1, "mouse")).begins).toBe(true);
  });
});

describe("a sample", () => {
  it("is in fractions of the cell", () => {
    const event = { clientX: 150, clientY: 120, timeStamp: 1016, pressure: 0.7, tiltX: 20, tiltY: -10 };
    expect(sampleOf(event, { left: 100, top: 20, width: 200, height: 200 }, 1000)).toEqual([0.25, 0.5, 16, 0.7, 20, -10]);
  });
});
