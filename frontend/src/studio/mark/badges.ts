// Positions of the remarks' numbers on the copy.

import type { Remark } from "../../types";

type Badge = { x: number; y: number };
type Bounds = readonly [x0: number, y0: number, x1: number, y1: number];

/** Bounding box of what a remark is about, in fractions of the cell; null if it is about the whole character. */
export function remarkBounds(remark: Pick<Remark, "region" | "outline">): Bounds | null {
  const points = remark.outline.flat();
  if (points.length) {
    const [xs, ys] = [points.map((p) => p[0]), points.map((p) => p[1])];
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }
  return remark.region;
}

/** One badge for each remark, at the upper left of its bounding box or, without one, of the cell; at least `gap` apart. */
export function placeBadges(remarks: readonly Pick<Remark, "region" | "outline">[], gap = 0.075): Badge[] {
  const set: Badge[] = [];
  for (const remark of remarks) {
    const box = remarkBounds(remark);
    const wanted = box ? { x: within(box[0]), y: within(box[1]) } : { x: 0.05, y: 0.05 };
    set.push(freePosition(wanted, set, gap));
  }
  return set;
}

const within = (value: number): number => Math.min(0.95, Math.max(0.05, value));

/** The first position on widening rings that keeps its distance from the others. */
function freePosition(wanted: Badge, taken: readonly Badge[], gap: number): Badge {
  for (let ring = 0; ring < 12; ring++) {
    for (let k = 0; k < Math.max(1, 8 * ring); k++) {
      const turn = (2 * Math.PI * k) / Math.max(1, 8 * ring);
      const at = { x: within(wanted.x + ring * gap * 0.5 * Math.cos(turn)), y: within(wanted.y + ring * gap * 0.5 * Math.sin(turn)) };
      if (taken.every((other) => Math.hypot(other.x - at.x, other.y - at.y) >= gap)) return at;
    }
  }
  return wanted;
}
