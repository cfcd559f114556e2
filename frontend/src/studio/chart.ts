// The places of a curve of marks on paper. Pure, so that it can be checked.

export type Point = { id: string; created: string; score: number | null; interval: [number, number] | null };
export type Dot = { x: number; y: number; low: number; high: number; point: Point };
export type Frame = { width: number; height: number; left: number; right: number; top: number; bottom: number };

export const heightOf = (score: number, frame: Frame): number =>
  frame.height - frame.bottom - (Math.min(100, Math.max(0, score)) / 100) * (frame.height - frame.top - frame.bottom);

/** One dot an attempt that got a mark: evenly spaced in their order, since practice comes in bursts. */
export function dots(points: readonly Point[], frame: Frame): Dot[] {
  const marked = points.filter((point) => point.score !== null);
  const room = frame.width - frame.left - frame.right;
  return marked.map((point, k) => ({
    x: frame.left + (marked.length > 1 ? (k / (marked.length - 1)) * room : room / 2),
    y: heightOf(point.score!, frame),
    low: heightOf(point.interval?.[0] ?? point.score!, frame),
    high: heightOf(point.interval?.[1] ?? point.score!, frame),
    point,
  }));
}

export const pathOf = (found: readonly Dot[]): string => found.map(({ x, y }, k) => `${k ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

/** The band of the intervals, as one closed outline. */
export function bandOf(found: readonly Dot[]): string {
  if (found.length < 2) return "";
  const there = found.map(({ x, high }, k) => `${k ? "L" : "M"}${x.toFixed(1)} ${high.toFixed(1)}`);
  const back = [...found].reverse().map(({ x, low }) => `L${x.toFixed(1)} ${low.toFixed(1)}`);
  return `${[...there, ...back].join("")}Z`;
}
