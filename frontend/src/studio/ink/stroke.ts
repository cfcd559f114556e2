// A stroke as the hand made it, before any brush. It is what is kept: every picture is drawn from it anew.

/** x, y: fractions of the cell, origin top left; t: ms since the stroke began; pressure: 0-1; tilts: degrees, -90 to 90. */
export type Sample = readonly [x: number, y: number, t: number, pressure: number, tiltX: number, tiltY: number];
export type Hand = "pen" | "mouse" | "touch";

/** size: radius of the fully pressed brush, fraction of the cell. ink: 0 dry, 1 wet. */
export type Stroke = { hand: Hand; size: number; ink: number; points: Sample[] };

export type Sheet = { version: 1; strokes: Stroke[] };

/** Whether the pen tells its pressure: a mouse says 0.5 for ever, many a finger 0 or 1. */
export function tellsPressure(points: readonly Sample[]): boolean {
  let low = 1;
  let high = 0;
  for (const point of points) {
    low = Math.min(low, point[3]);
    high = Math.max(high, point[3]);
  }
  return high - low > 0.04;
}

/** What is kept and sent: five digits of a place are a hundredth of a pixel at 512. */
export function sheetOf(strokes: readonly Stroke[]): Sheet {
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

/** The strokes of a kept sheet; what is no sheet gives none. */
export function strokesOf(kept: unknown): Stroke[] {
  const strokes = (kept as Partial<Sheet> | null)?.strokes;
  if (!Array.isArray(strokes)) return [];
  return strokes.filter((stroke) => Array.isArray(stroke?.points) && stroke.points.length > 0 && stroke.size > 0);
}
