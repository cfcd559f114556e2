// A whole work and the characters within it: columns of its text, and the character under a point of the picture.

import type { CharacterWithin } from "../types";

export const UNKNOWN = "〓";

type Point = { x: number; y: number };

/** The characters of a work, in its picture and in its text alike. */
export type Characters = {
  characters: CharacterWithin[];
  /** Under the pointer, here or there. */
  lit: CharacterWithin | null;
  chosen: CharacterWithin | null;
  /** Whether all boxes are drawn. */
  shown: boolean;
  light: (one: CharacterWithin | null) => void;
  choose: (one: CharacterWithin | null) => void;
};

/** The columns of a page in reading order; on a modern page, its rows. */
export function columnsOf(characters: CharacterWithin[]): CharacterWithin[][] {
  const columns: CharacterWithin[][] = [];
  let last = "";
  for (const one of characters) {
    const line = `${one.place.register}/${one.place.column}`;
    if (line !== last) columns.push([]);
    columns.at(-1)!.push(one);
    last = line;
  }
  return columns;
}

/** Whether a point lies within a polygon: a ray to the left crosses its edges an odd number of times. */
export function isWithin(point: Point, polygon: [number, number][]): boolean {
  let inside = false;
  polygon.forEach(([x0, y0], k) => {
    const [x1, y1] = polygon[(k + 1) % polygon.length]!;
    if (y0 > point.y !== y1 > point.y && point.x < x0 + ((point.y - y0) / (y1 - y0)) * (x1 - x0)) inside = !inside;
  });
  return inside;
}

/** The character under a point of the picture; where two overlap, the one whose middle is nearer. */
export function characterAt(characters: CharacterWithin[], point: Point): CharacterWithin | null {
  let best: CharacterWithin | null = null;
  let nearest = Infinity;
  for (const one of characters) {
    if (!isWithin(point, one.place.polygon)) continue;
    const [x, y] = middleOf(one.place.polygon);
    const distance = Math.hypot(x - point.x, y - point.y);
    if (distance < nearest) [best, nearest] = [one, distance];
  }
  return best;
}

export function middleOf(polygon: [number, number][]): [number, number] {
  const sum = polygon.reduce(([x, y], [px, py]) => [x + px, y + py] as [number, number], [0, 0] as [number, number]);
  return [sum[0] / polygon.length, sum[1] / polygon.length];
}
