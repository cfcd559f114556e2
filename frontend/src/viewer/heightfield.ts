// Heights of the sheet: at a point, along a line, or where a ray from the camera meets them.

import type { ViewerFacts } from "../types";
import { bilinear, type Vec3 } from "./shading";
import { WHOLE } from "./grid";
import type { HeightPatch } from "./nearHeights";
import type { Part } from "./pyramid";
import type { SheetLine } from "./state";

export type ProfilePoint = { distance: number; height: number };

/** Heights over the whole sheet or a part of it, row by row from the top. */
type Heights = { values: Float32Array; width: number; height: number; part?: Part };

export class HeightField {
  /** Size of the sheet where its longer side is 1. */
  readonly wide: number;
  readonly tall: number;
  /** Length of the longer side in `unit`. */
  readonly scale: number;
  /** Finer heights over the part that is seen, where there are some. */
  near: HeightPatch | null = null;

  constructor(
    readonly values: Float32Array,
    readonly width: number,
    readonly height: number,
    readonly min: number,
    readonly max: number,
    readonly sheet: { width: number; height: number; spacing: number; unit: "mm" | "px" },
  ) {
    if (values.length !== width * height) {
      throw new Error(`expected ${width} x ${height} heights, got ${values.length}`);
    }
    const longest = Math.max(sheet.width, sheet.height);
    this.wide = sheet.width / longest;
    this.tall = sheet.height / longest;
    this.scale = longest * sheet.spacing;
  }

  static from(facts: ViewerFacts, values: Float32Array): HeightField {
    const { width, height, min, max } = facts.heights;
    return new HeightField(values, width, height, min, max, facts);
  }

  /** Height in `unit` at fractions of the sheet, origin top left. */
  at(u: number, v: number): number {
    const part = this.near?.part;
    const within = part && u >= part.left && u <= part.right && v >= part.top && v <= part.bottom;
    return heightIn(within ? this.near! : this, u, v);
  }

  /** Length in `unit` of a line given in fractions of the sheet. */
  length([x0, y0, x1, y1]: SheetLine): number {
    return Math.hypot((x1 - x0) * this.wide, (y1 - y0) * this.tall) * this.scale;
  }

  /** `count` heights along the line, both ends included; distance from its first point; both in `unit`. */
  section(line: SheetLine, count = 256): ProfilePoint[] {
    const [x0, y0, x1, y1] = line;
    const total = this.length(line);
    return Array.from({ length: count }, (_, k) => {
      const t = k / (count - 1);
      return { distance: total * t, height: this.at(x0 + (x1 - x0) * t, y0 + (y1 - y0) * t) };
    });
  }

  /** The point of the scene at fractions (u, v), with heights times `lift`. */
  point(u: number, v: number, lift: number): Vec3 {
    return [(u - 0.5) * this.wide, (0.5 - v) * this.tall, lift === 0 ? 0 : (this.at(u, v) / this.scale) * lift];
  }

  /** Fractions of the first point where a ray meets the surface, or null if it misses the sheet. */
  intersectRay(origin: Vec3, direction: Vec3, lift: number, steps = 400): { u: number; v: number } | null {
    const bound = (Math.max(Math.abs(this.min), Math.abs(this.max)) / this.scale) * lift + 1e-4;
    if (Math.abs(direction[2]) < 1e-9) return null;
    const [near, far] = [(bound - origin[2]) / direction[2], (-bound - origin[2]) / direction[2]].sort((a, b) => a - b) as [number, number];
    if (far < 0) return null;
    const fractions = (t: number) => ({
      u: (origin[0] + direction[0] * t) / this.wide + 0.5,
      v: 0.5 - (origin[1] + direction[1] * t) / this.tall,
    });
    const inside = ({ u, v }: { u: number; v: number }) => u >= 0 && u <= 1 && v >= 0 && v <= 1;
    if (lift === 0) {
      const point = fractions(-origin[2] / direction[2]);
      return inside(point) ? point : null;
    }
    const start = Math.max(near, 0);
    let before: number | null = null;
    for (let k = 0; k <= steps; k++) {
      const t = start + ((far - start) * k) / steps;
      const point = fractions(t);
      if (!inside(point)) {
        before = null;
        continue;
      }
      const above = origin[2] + direction[2] * t - this.point(point.u, point.v, lift)[2];
      if (before !== null && Math.sign(above) !== Math.sign(before)) return point;
      before = above === 0 ? 1e-12 : above;
    }
    return null;
  }
}

/** Height at fractions of the sheet in heights of the whole or of a part. */
export function heightIn({ values, width, height, part = WHOLE }: Heights, u: number, v: number): number {
  const [x, y] = [(u - part.left) / (part.right - part.left), (v - part.top) / (part.bottom - part.top)];
  return bilinear(x, y, width, height, (c, r) => values[r * width + c]!);
}

/**
 * Heights averaged under a tent that reaches about `radius` texels to each side, so that a grid of squares of that
 * size steps over an edge without stairs. weights: what each height counts, such as whether it was measured.
 */
export function smoothed({ values, width, height }: Heights, radius: number, weights?: Float32Array): Float32Array {
  const reach = Math.round(radius / 2);
  if (reach === 0) return values;
  const blur = (means: Float32Array) => {
    for (let pass = 0; pass < 2; pass++) means = boxMeans(boxMeans(means, width, height, reach, 1), height, width, reach, width);
    return means;
  };
  if (!weights) return blur(values);
  const sums = blur(values.map((value, k) => value * weights[k]!));
  const counted = blur(weights);
  return sums.map((sum, k) => (counted[k]! > 1e-3 ? sum / counted[k]! : values[k]!));
}

/** Means of 2 reach + 1 neighbours along lines of `length`, whose values lie `step` apart; edges are repeated. */
function boxMeans(values: Float32Array, length: number, lines: number, reach: number, step: number): Float32Array {
  const means = new Float32Array(values.length);
  const next = step === 1 ? length : 1;
  for (let line = 0; line < lines; line++) {
    const at = (k: number) => values[line * next + Math.min(Math.max(k, 0), length - 1) * step]!;
    let sum = 0;
    for (let k = -reach; k <= reach; k++) sum += at(k);
    for (let k = 0; k < length; k++) {
      means[line * next + k * step] = sum / (2 * reach + 1);
      sum += at(k + reach + 1) - at(k - reach);
    }
  }
  return means;
}
