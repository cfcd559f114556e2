// Where the crop of a photograph begins: on the printed cell, else on the picture itself, else around the writing. It never cuts ink.

import type { Square } from "./crop";
import { findCell } from "./gridCell";
import { type Box, boxOf, findDrawn, findInk, type InkParts, type Raster } from "./photoInk";
import { onPaperAlone } from "./photoSheet";

/** What the crop was laid on. With `ink`, size and place in the cell are the master's, since the photograph shows no cell. */
export type CropReason = "grid" | "picture" | "ink";
/** square: in pixels of the small copy; may reach beyond it. ink: without printed lines. */
export type FirstCrop = { square: Square; reason: CropReason; ink: InkParts };
/** Where the master's ink is, in fractions of the longer side of its cell, from the corner of the square around that cell. */
export type MasterShape = Box;

const CELL_ASPECT = 1.15; // longer over shorter side: up to here a picture may be one cell
const CELL_FILLED = 0.3; // of the side, by writing: a smaller one is a sheet
const MARGIN = 0.04; // of the crop, on each side of the writing
const COMMON_SHAPE: MasterShape = { x0: 0.12, y0: 0.12, x1: 0.88, y1: 0.88 }; // while the master's is not known

export function firstCrop(raster: Raster, master: MasterShape | null): FirstCrop {
  const paper = onPaperAlone(raster);
  const { cell, ink } = findCell(findInk(paper), findDrawn(paper));
  const { width, height } = raster;
  const longer = Math.max(width, height);
  const picture = { x: (width - longer) / 2, y: (height - longer) / 2, side: longer };
  if (cell) {
    const square = around(cell, boxOf(ink.parts.filter((part) => isMostlyIn(part, cell))));
    return { square, reason: "grid", ink };
  }
  const box = boxOf(ink.parts);
  if (!box) return { square: picture, reason: "picture", ink };
  const filled = Math.max(box.x1 - box.x0, box.y1 - box.y0) / longer;
  if (longer <= CELL_ASPECT * Math.min(width, height) && filled >= CELL_FILLED) return { square: picture, reason: "picture", ink };
  return { square: asLargeAs(master ?? COMMON_SHAPE, box), reason: "ink", ink };
}

/** The square in which the writing has the size and the place that the master has in its cell, with a margin at least. */
function asLargeAs(master: MasterShape, box: Box): Square {
  const [wide, tall] = [box.x1 - box.x0 + 1, box.y1 - box.y0 + 1];
  const share = Math.sqrt((master.x1 - master.x0) * (master.y1 - master.y0));
  const side = Math.max(Math.sqrt(wide * tall) / Math.max(0.1, share), Math.max(wide, tall) / (1 - 2 * MARGIN));
  const [x, y] = [(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2];
  const square = { x: x - (side * (master.x0 + master.x1)) / 2, y: y - (side * (master.y0 + master.y1)) / 2, side };
  const clamp = (value: number, low: number, high: number) => Math.min(high, Math.max(low, value));
  const margin = MARGIN * side;
  return { ...square, x: clamp(square.x, box.x1 + 1 + margin - side, box.x0 - margin), y: clamp(square.y, box.y1 + 1 + margin - side, box.y0 - margin) };
}

/** The square, enlarged about its middle until nothing of a box is cut. */
function around(square: Square, box: Box | null): Square {
  if (!box) return square;
  const [x, y] = [square.x + square.side / 2, square.y + square.side / 2];
  const half = Math.max(square.side / 2, x - box.x0, box.x1 + 1 - x, y - box.y0, box.y1 + 1 - y);
  return { x: x - half, y: y - half, side: 2 * half };
}

const isMostlyIn = (box: Box, { x, y, side }: Square): boolean => {
  const overlap = (from: number, to: number, start: number) => Math.max(0, Math.min(to, start + side) - Math.max(from, start)) / Math.max(1, to - from);
  return overlap(box.x0, box.x1, x) * overlap(box.y0, box.y1, y) > 0.5;
};

/** The pixels of ink that a square cuts off: those beyond its edges, of parts that it cuts in two. */
export function cutInk({ numbers, width, parts }: InkParts, { x, y, side }: Square): number[] {
  const cut: number[] = [];
  for (const part of parts) {
    const [outside, all]: [number[], number] = [[], part.count];
    if (part.x0 >= x - SLACK && part.x1 + 1 <= x + side + SLACK && part.y0 >= y - SLACK && part.y1 + 1 <= y + side + SLACK) continue;
    for (let v = part.y0; v <= part.y1; v++)
      for (let u = part.x0; u <= part.x1; u++) {
        if (numbers[v * width + u] !== part.number) continue;
        if (u + 0.5 < x - SLACK || u + 0.5 > x + side + SLACK || v + 0.5 < y - SLACK || v + 0.5 > y + side + SLACK) outside.push(v * width + u);
      }
    if (outside.length && outside.length < all) cut.push(...outside);
  }
  return cut;
}

const SLACK = 1; // pixels of the small copy by which ink may be finer than it shows
