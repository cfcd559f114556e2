// Which pointer draws a stroke: a palm that rests on the screen must leave no ink. And pointer events as samples.

import type { PointerKind, Sample } from "./strokes";

/** active: id of the pointer that is drawing. */
export type PointerState = { penSeen: boolean; active: number | null };
export const NO_POINTER: PointerState = { penSeen: false, active: null };

type Touch = { pointerId: number; pointerType: string; isPrimary: boolean; button: number };

export const pointerKind = (pointerType: string): PointerKind =>
  pointerType === "pen" || pointerType === "touch" ? pointerType : "mouse";

/** Whether this touch begins a stroke, and the state afterwards. Once a pen has been used, fingers and palms are ignored. */
export function acceptPointer(pointers: PointerState, touch: Touch): { begins: boolean; takesOver: boolean; pointers: PointerState } {
  const pen = touch.pointerType === "pen";
  const penSeen = pointers.penSeen || pen;
  const allowed = pen || (touch.pointerType === "touch" ? !penSeen && touch.isPrimary : touch.button === 0);
  const takesOver = pen && !pointers.penSeen && pointers.active !== null; // the palm came down before the pen
  const begins = allowed && (pointers.active === null || takesOver);
  return { begins, takesOver, pointers: { penSeen, active: begins ? touch.pointerId : pointers.active } };
}

export const releasePointer = (pointers: PointerState, pointerId: number): PointerState =>
  pointers.active === pointerId ? { ...pointers, active: null } : pointers;

type CellBox = { left: number; top: number; width: number; height: number };
type PointerSample = { clientX: number; clientY: number; timeStamp: number; pressure: number; tiltX: number; tiltY: number };

/** A pointer event in fractions of the cell. began: time stamp of the stroke's first event. */
export const sampleOf = (event: PointerSample, cell: CellBox, began: number): Sample => [
  (event.clientX - cell.left) / cell.width,
  (event.clientY - cell.top) / cell.height,
  Math.max(0, event.timeStamp - began),
  event.pressure,
  event.tiltX || 0,
  event.tiltY || 0,
];
