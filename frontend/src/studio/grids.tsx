// The grids of a cell (米字格, 九宮格, 田字格): their lines, in fractions of the cell, and their drawings.

import type { Grid } from "../types";

type GridLine = readonly [x0: number, y0: number, x1: number, y1: number];

const CROSS: GridLine[] = [[0.5, 0, 0.5, 1], [0, 0.5, 1, 0.5]];
const DIAGONALS: GridLine[] = [[0, 0, 1, 1], [1, 0, 0, 1]];
const THIRDS: GridLine[] = [1 / 3, 2 / 3].flatMap((at): GridLine[] => [[at, 0, at, 1], [0, at, 1, at]]);

export const GRIDS: Grid[] = ["mi", "jiu", "tian", ""];

export const linesOf = (grid: Grid): GridLine[] =>
  grid === "mi" ? [...CROSS, ...DIAGONALS] : grid === "jiu" ? THIRDS : grid === "tian" ? CROSS : [];

export const gridName = (grid: Grid) => (grid ? (`grid_${grid}` as const) : ("grid_none" as const));

export function GridIcon({ grid }: { grid: Grid }) {
  return (
    <svg class="grid-icon" viewBox="-0.05 -0.05 1.1 1.1" aria-hidden="true">
      <rect width="1" height="1" />
      {linesOf(grid).map(([x1, y1, x2, y2], k) => (
        <line key={k} {...{ x1, y1, x2, y2 }} />
      ))}
    </svg>
  );
}

export function GridLines({ grid }: { grid: Grid }) {
  return (
    <svg class="cell-grid" viewBox="0 0 1 1" aria-hidden="true">
      {linesOf(grid).map(([x1, y1, x2, y2], k) => (
        <line key={k} {...{ x1, y1, x2, y2 }} vector-effect="non-scaling-stroke" />
      ))}
    </svg>
  );
}
