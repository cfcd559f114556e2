// Round steps for scales, lengths as text, and the layout of a plotted cross-section.

import type { ProfilePoint } from "./heightfield";

/** A round step (1, 2 or 5 times a power of ten) that divides `range` into about `count` parts. */
export function niceStep(range: number, count: number): number {
  if (!(range > 0)) return 1;
  const rough = range / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const lead = rough / power;
  return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

/** Multiples of a round step inside [low, high]. */
export function roundLevels(low: number, high: number, count: number): number[] {
  const step = niceStep(high - low, count);
  const first = Math.ceil(low / step - 1e-9);
  const multiples: number[] = [];
  for (let k = first; k * step <= high + step * 1e-9; k++) multiples.push(Number((k * step).toPrecision(12)));
  return multiples;
}

export type Unit = "mm" | "px";

/** A length with its unit, to three significant digits at most. */
export function formatLength(value: number, unit: Unit): string {
  const size = Math.abs(value);
  const digits = unit === "px" ? (size < 10 ? 1 : 0) : size < 0.1 ? 3 : size < 10 ? 2 : 1;
  return `${value.toFixed(digits)} ${unit}`;
}

type Plot = { path: string; area: string; x: (distance: number) => number; y: (height: number) => number; across: number[]; up: number[] };

/** A cross-section laid out in a box: x along the line, y upward, ticks at round values. */
export function layoutPlot(points: ProfilePoint[], box: { left: number; right: number; top: number; bottom: number }): Plot {
  const total = points.at(-1)?.distance || 1;
  const heights = points.map((p) => p.height);
  const [low, high] = [Math.min(...heights), Math.max(...heights)];
  const spare = (high - low || 1) * 0.08;
  const x = (d: number) => box.left + (d / total) * (box.right - box.left);
  const y = (h: number) => box.bottom - ((h - low + spare) / (high - low + 2 * spare || 1)) * (box.bottom - box.top);
  const path = points.map((p, k) => `${k ? "L" : "M"}${x(p.distance).toFixed(1)} ${y(p.height).toFixed(1)}`).join("");
  const area = `${path}L${x(total).toFixed(1)} ${box.bottom}L${box.left} ${box.bottom}Z`;
  return { path, area, x, y, across: roundLevels(0, total, 6), up: roundLevels(low, high, 3) };
}
