// Undo and redo, as values.

import type { Stroke } from "./stroke";

export type History = { done: readonly Stroke[]; undone: readonly Stroke[]; cleared: readonly Stroke[] | null };

export const blank: History = { done: [], undone: [], cleared: null };

export const written = (strokes: readonly Stroke[]): History => ({ ...blank, done: strokes });

export const add = (history: History, stroke: Stroke): History => ({
  done: [...history.done, stroke],
  undone: [],
  cleared: null,
});

/** Take the last stroke back; right after a clearing, take the clearing back. */
export function undo(history: History): History {
  if (history.cleared) return { done: history.cleared, undone: [], cleared: null };
  const last = history.done.at(-1);
  return last ? { done: history.done.slice(0, -1), undone: [...history.undone, last], cleared: null } : history;
}

export function redo(history: History): History {
  const last = history.undone.at(-1);
  return last ? { done: [...history.done, last], undone: history.undone.slice(0, -1), cleared: null } : history;
}

export const clear = (history: History): History =>
  history.done.length ? { done: [], undone: [], cleared: history.done } : history;

export const canUndo = (history: History): boolean => history.done.length > 0 || history.cleared !== null;
export const canRedo = (history: History): boolean => history.undone.length > 0;
