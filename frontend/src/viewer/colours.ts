// Colours for heights: thirty-three anchors of viridis (S. van der Walt and N. Smith, released under CC0), straight between them.

import type { Vec3 } from "./arithmetic";

// prettier-ignore
export const ANCHORS: readonly Vec3[] = [
  [0.267, 0.0049, 0.3294], [0.277, 0.0502, 0.3755], [0.2823, 0.0946, 0.417], [0.2829, 0.1354, 0.453],
  [0.2789, 0.1749, 0.483], [0.2708, 0.2133, 0.5066], [0.2593, 0.2507, 0.5244], [0.2454, 0.2867, 0.537],
  [0.2302, 0.3213, 0.5455], [0.2148, 0.3545, 0.551], [0.2, 0.3864, 0.5545], [0.1861, 0.4173, 0.5567],
  [0.1733, 0.4474, 0.5579], [0.1613, 0.477, 0.5581], [0.1497, 0.5064, 0.5573], [0.1384, 0.5358, 0.5551],
  [0.1281, 0.5651, 0.5509], [0.1209, 0.5945, 0.5442], [0.1203, 0.6238, 0.5343], [0.131, 0.6529, 0.5208],
  [0.1554, 0.6815, 0.5032], [0.193, 0.7096, 0.4812], [0.2415, 0.7366, 0.4545], [0.2986, 0.7624, 0.423],
  [0.3629, 0.7867, 0.3866], [0.433, 0.8091, 0.3453], [0.5081, 0.8292, 0.2992], [0.5873, 0.847, 0.2489],
  [0.6694, 0.8622, 0.1954], [0.7529, 0.8751, 0.1427], [0.8359, 0.8861, 0.1025], [0.9166, 0.8961, 0.1008],
  [0.9932, 0.9062, 0.1439],
];

/** sRGB code values in [0, 1] of a height at `t` between lowest (0) and highest (1). */
export function heightColour(t: number): Vec3 {
  const x = Math.min(Math.max(t, 0), 1) * (ANCHORS.length - 1);
  const k = Math.min(Math.floor(x), ANCHORS.length - 2);
  const [low, high] = [ANCHORS[k]!, ANCHORS[k + 1]!];
  const f = x - k;
  return [low[0] + (high[0] - low[0]) * f, low[1] + (high[1] - low[1]) * f, low[2] + (high[2] - low[2]) * f];
}

export function cssColour(t: number): string {
  return `rgb(${heightColour(t).map((v) => Math.round(v * 255)).join(" ")})`;
}

/** A round step (1, 2 or 5 times a power of ten) that cuts `range` into about `count` pieces. */
export function niceStep(range: number, count: number): number {
  if (!(range > 0)) return 1;
  const rough = range / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const lead = rough / power;
  return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

/** Multiples of a round step inside [low, high]. */
export function levels(low: number, high: number, count: number): number[] {
  const step = niceStep(high - low, count);
  const first = Math.ceil(low / step - 1e-9);
  const found: number[] = [];
  for (let k = first; k * step <= high + step * 1e-9; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}
