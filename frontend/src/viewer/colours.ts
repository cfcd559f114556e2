// Colours for heights: seventeen anchors of viridis (S. van der Walt and N. Smith, released under CC0), straight between them.

import type { Vec3 } from "./arithmetic";

// prettier-ignore
export const ANCHORS: readonly Vec3[] = [
  [0.267, 0.0049, 0.3294], [0.2823, 0.095, 0.4173], [0.2788, 0.1755, 0.4834], [0.259, 0.2515, 0.5247],
  [0.2297, 0.3224, 0.5457], [0.1994, 0.3876, 0.5546], [0.1727, 0.4488, 0.5579], [0.149, 0.5081, 0.5573],
  [0.1276, 0.5669, 0.5506], [0.1206, 0.6258, 0.5335], [0.1579, 0.6838, 0.5017], [0.2461, 0.7389, 0.452],
  [0.3692, 0.7889, 0.3829], [0.516, 0.8312, 0.2943], [0.6785, 0.8637, 0.1895], [0.8456, 0.8873, 0.0997],
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
