// Strokes as the hand made them, which are saved and from which every picture is drawn; and their undo history.

/** x, y: fractions of the cell, origin top left; t: ms since the stroke began; pressure: 0-1; tilts: degrees, -90 to 90. */
export type Sample = readonly [x: number, y: number, t: number, pressure: number, tiltX: number, tiltY: number];
export type PointerKind = "pen" | "mouse" | "touch";

/** size: radius of the fully pressed brush, fraction of the cell. ink: 0 dry, 1 wet. */
export type Stroke = { hand: PointerKind; size: number; ink: number; points: Sample[] };

type SheetData = { version: 1; strokes: Stroke[] };

/** Whether the pointer measures pressure: a mouse always reports 0.5, many touch screens 0 or 1. */
export function hasPressure(points: readonly Sample[]): boolean {
  let low = 1;
  let high = 0;
  for (const point of points) {
    low = Math.min(low, point[3]);
    high = Math.max(high, point[3]);
  }
  return high - low > 0.04;
}

/** The form in which strokes are saved and sent; five digits are a hundredth of a pixel at a side of 512. */
export function serializeStrokes(strokes: readonly Stroke[]): SheetData {
  const short = (value: number, digits: number) => Number(value.toFixed(digits));
  return {
    version: 1,
    strokes: strokes.map((stroke) => ({
      ...stroke,
      points: stroke.points.map(
        ([x, y, t, p, tx, ty]): Sample => [short(x, 5), short(y, 5), short(t, 1), short(p, 3), short(tx, 1), short(ty, 1)],
      ),
    })),
  };
}

/** The strokes of saved data; none if it is something else. */
export function parseStrokes(saved: unknown): Stroke[] {
  const strokes = (saved as Partial<SheetData> | null)?.strokes;
  if (!Array.isArray(strokes)) return [];
  return strokes.filter((stroke) => Array.isArray(stroke?.points) && stroke.points.length > 0 && stroke.size > 0);
}

export type History = { done: readonly Stroke[]; undone: readonly Stroke[]; cleared: readonly Stroke[] | null };

export const EMPTY_HISTORY: History = { done: [], undone: [], cleared: null };

export const historyOf = (strokes: readonly Stroke[]): History => ({ ...EMPTY_HISTORY, done: strokes });

export const addStroke = (history: History, stroke: Stroke): History => ({
  done: [...history.done, stroke],
  undone: [],
  cleared: null,
});

/** Removes the last stroke or, right after clearing, restores what was cleared. */
export function undo(history: History): History {
  if (history.cleared) return { done: history.cleared, undone: [], cleared: null };
  const last = history.done.at(-1);
  return last ? { done: history.done.slice(0, -1), undone: [...history.undone, last], cleared: null } : history;
}

export function redo(history: History): History {
  const last = history.undone.at(-1);
  return last ? { done: [...history.done, last], undone: history.undone.slice(0, -1), cleared: null } : history;
}

export const clearStrokes = (history: History): History =>
  history.done.length ? { done: [], undone: [], cleared: history.done } : history;

export const canUndo = (history: History): boolean => history.done.length > 0 || history.cleared !== null;
export const canRedo = (history: History): boolean => history.undone.length > 0;
