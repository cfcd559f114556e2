// The lines under the brush, in fractions of the cell.

import type { Grid } from "../../types";

export type Line = readonly [x0: number, y0: number, x1: number, y1: number];

const CROSS: Line[] = [[0.5, 0, 0.5, 1], [0, 0.5, 1, 0.5]];
const DIAGONALS: Line[] = [[0, 0, 1, 1], [1, 0, 0, 1]];
const THIRDS: Line[] = [1 / 3, 2 / 3].flatMap((at): Line[] => [[at, 0, at, 1], [0, at, 1, at]]);

export const GRIDS: Grid[] = ["mi", "jiu", "tian", ""];

export const linesOf = (grid: Grid): Line[] =>
  grid === "mi" ? [...CROSS, ...DIAGONALS] : grid === "jiu" ? THIRDS : grid === "tian" ? CROSS : [];
