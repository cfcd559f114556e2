// The four corners of a cell in a photograph, where it was taken from the side or the paper lies askew. Lengths in pixels.

import { MIN_SIDE, type Size, type Square } from "./crop";

export type Point = readonly [x: number, y: number];
/** Clockwise from the upper left. */
export type Corners = readonly [Point, Point, Point, Point];

export const TURN = { most: 15, step: 0.5 }; // degrees of the fine turn

export const cornersOf = ({ x, y, side }: Square): Corners => [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];

const middleOf = (corners: Corners): Point => [0, 1].map((axis) => corners.reduce((sum, corner) => sum + corner[axis]!, 0) / 4) as unknown as Point;

/** The corners turned clockwise about their middle. */
export function turnCorners(corners: Corners, degrees: number): Corners {
  const [mx, my] = middleOf(corners);
  const [cos, sin] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return mapCorners(corners, ([x, y]) => [mx + cos * (x - mx) - sin * (y - my), my + sin * (x - mx) + cos * (y - my)]);
}

/** One corner moved to a place within the picture; as before where the cell would not stay convex, or become too small. */
export function moveCorner(corners: Corners, index: number, [x, y]: Point, { width, height }: Size): Corners {
  const to: Point = [Math.min(width, Math.max(0, x)), Math.min(height, Math.max(0, y))];
  const moved = corners.map((corner, k) => (k === index ? to : corner)) as unknown as Corners;
  return isCell(moved) ? moved : corners;
}

/** All corners moved, as far as they stay within the picture. */
export function moveCorners(corners: Corners, dx: number, dy: number, { width, height }: Size): Corners {
  const within = (by: number, values: number[], most: number) => Math.max(Math.min(0, -Math.min(...values)), Math.min(by, Math.max(0, most - Math.max(...values))));
  const [x, y] = [within(dx, corners.map((corner) => corner[0]), width), within(dy, corners.map((corner) => corner[1]), height)];
  return mapCorners(corners, (corner) => [corner[0] + x, corner[1] + y]);
}

/** Whether corners are those of a cell: convex, clockwise, no side too short. */
export function isCell(corners: Corners): boolean {
  const ways = corners.map((corner, k) => [corners[(k + 1) % 4]![0] - corner[0], corners[(k + 1) % 4]![1] - corner[1]] as const);
  return ways.every(([x, y], k) => {
    const [nx, ny] = ways[(k + 1) % 4]!;
    return x * ny - y * nx > 0 && Math.hypot(x, y) >= MIN_SIDE;
  });
}

const mapCorners = (corners: Corners, change: (corner: Point) => Point): Corners => corners.map(change) as unknown as Corners;

/** How corners are sent: [[x, y], ...] to a tenth of a pixel. */
export const cornersText = (corners: Corners): string => JSON.stringify(corners.map((corner) => corner.map((value) => Math.round(10 * value) / 10)));
