// Lengths in words, and points of a plot.

import { levels } from "./colours";
import type { ProfilePoint } from "./heightfield";

export type Unit = "mm" | "px";

/** Three significant digits at most, with the unit. */
export function length(value: number, unit: Unit): string {
  const size = Math.abs(value);
  const digits = unit === "px" ? (size < 10 ? 1 : 0) : size < 0.1 ? 3 : size < 10 ? 2 : 1;
  return `${value.toFixed(digits)} ${unit}`;
}

export type Plot = { path: string; area: string; x: (distance: number) => number; y: (height: number) => number; across: number[]; up: number[] };

/** A profile laid out in a box: x along the line, y upward, both axes from round levels. */
export function plot(points: ProfilePoint[], box: { left: number; right: number; top: number; bottom: number }): Plot {
  const whole = points.at(-1)?.distance || 1;
  const heights = points.map((p) => p.height);
  const [low, high] = [Math.min(...heights), Math.max(...heights)];
  const spare = (high - low || 1) * 0.08;
  const x = (d: number) => box.left + (d / whole) * (box.right - box.left);
  const y = (h: number) => box.bottom - ((h - low + spare) / (high - low + 2 * spare || 1)) * (box.bottom - box.top);
  const path = points.map((p, k) => `${k ? "L" : "M"}${x(p.distance).toFixed(1)} ${y(p.height).toFixed(1)}`).join("");
  const area = `${path}L${x(whole).toFixed(1)} ${box.bottom}L${box.left} ${box.bottom}Z`;
  return { path, area, x, y, across: levels(0, whole, 6), up: levels(low, high, 3) };
}
