// Which touch is a stroke. A palm that rests on the page must leave no ink.

import type { Hand, Sample } from "./stroke";

export type Gate = { penSeen: boolean; active: number | null };
export const openGate: Gate = { penSeen: false, active: null };

type Touch = { pointerId: number; pointerType: string; isPrimary: boolean; button: number };

export const handOf = (pointerType: string): Hand =>
  pointerType === "pen" || pointerType === "touch" ? pointerType : "mouse";

/** Whether this touch begins a stroke, and the gate afterwards. Once a pen was seen, fingers and palms are nothing. */
export function admit(gate: Gate, touch: Touch): { begins: boolean; takesOver: boolean; gate: Gate } {
  const pen = touch.pointerType === "pen";
  const penSeen = gate.penSeen || pen;
  const allowed = pen || (touch.pointerType === "touch" ? !penSeen && touch.isPrimary : touch.button === 0);
  const takesOver = pen && !gate.penSeen && gate.active !== null; // the palm came down before the pen
  const begins = allowed && (gate.active === null || takesOver);
  return { begins, takesOver, gate: { penSeen, active: begins ? touch.pointerId : gate.active } };
}

export const release = (gate: Gate, pointerId: number): Gate =>
  gate.active === pointerId ? { ...gate, active: null } : gate;

type Box = { left: number; top: number; width: number; height: number };
type Event = { clientX: number; clientY: number; timeStamp: number; pressure: number; tiltX: number; tiltY: number };

/** A pointer event in fractions of the cell. began: time stamp of the stroke's first event. */
export const sampleOf = (event: Event, cell: Box, began: number): Sample => [
  (event.clientX - cell.left) / cell.width,
  (event.clientY - cell.top) / cell.height,
  Math.max(0, event.timeStamp - began),
  event.pressure,
  event.tiltX || 0,
  event.tiltY || 0,
];
