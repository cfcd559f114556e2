// The mesh that a sheet, or what is seen of it, is drawn on.

import { BufferAttribute, BufferGeometry } from "three";
import type { Part } from "./pyramid";

type Size = { wide: number; tall: number };
type HeightAt = (u: number, v: number) => number;

export const WHOLE: Part = { left: 0, top: 0, right: 1, bottom: 1 };

/** How many squares lie along x and y where the longer side of a part has so many. */
export function squares(size: Size, longest: number, part: Part = WHOLE): [number, number] {
  const [wide, tall] = [size.wide * (part.right - part.left), size.tall * (part.bottom - part.top)];
  const side = Math.max(wide, tall) / longest;
  return [Math.max(2, Math.round(wide / side)), Math.max(2, Math.round(tall / side))];
}

/**
 * A flat grid over a part of the sheet, y up, with fractions of the sheet (origin top left) as its texture coordinates; faces look to +z.
 * heightAt: to where its vertices will be lifted: each square is folded between the two opposite corners that are nearest in height, or a
 * wall that runs the other way would become a saw.
 */
export function grid(size: Size, longest: number, heightAt?: HeightAt, part: Part = WHOLE): BufferGeometry {
  const [columns, rows] = squares(size, longest, part);
  const positions = new Float32Array((columns + 1) * (rows + 1) * 3);
  const fractions = new Float32Array((columns + 1) * (rows + 1) * 2);
  const u = (column: number) => part.left + (column / columns) * (part.right - part.left);
  const v = (row: number) => part.top + (row / rows) * (part.bottom - part.top);
  for (let r = 0, k = 0; r <= rows; r++) {
    for (let c = 0; c <= columns; c++, k++) {
      positions.set([(u(c) - 0.5) * size.wide, (0.5 - v(r)) * size.tall, 0], k * 3);
      fractions.set([u(c), v(r)], k * 2);
    }
  }
  const at = (c: number, r: number) => heightAt?.(u(c), v(r)) ?? 0;
  const folds = (c: number, r: number) => heightAt && Math.abs(at(c, r) - at(c + 1, r + 1)) < Math.abs(at(c + 1, r) - at(c, r + 1));
  const faces = new Uint32Array(columns * rows * 6);
  for (let r = 0, k = 0; r < rows; r++) {
    for (let c = 0; c < columns; c++, k += 6) {
      const a = r * (columns + 1) + c;
      const below = a + columns + 1;
      faces.set(folds(c, r) ? [a, below, below + 1, a, below + 1, a + 1] : [a, below, a + 1, a + 1, below, below + 1], k);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setAttribute("uv", new BufferAttribute(fractions, 2));
  geometry.setIndex(new BufferAttribute(faces, 1));
  return geometry;
}
