// Small drawings of the grids that sheets have; a dashed line is none of the frame.

import { linesOf } from "../studio/grids";
import type { SheetRequest } from "./request";

type SheetGrid = SheetRequest["grid"];

const INNER: Partial<Record<SheetGrid, Parameters<typeof linesOf>[0]>> = { mi: "mi", nine: "jiu", tian: "tian" };

export function SheetGridIcon({ grid }: { grid: SheetGrid }) {
  return (
    <svg class="grid-icon" viewBox="-0.05 -0.05 1.1 1.1" aria-hidden="true">
      {grid === "none" ? <path d="M0 .25V0H.25M.75 0H1V.25M1 .75V1H.75M.25 1H0V.75" /> : <rect width="1" height="1" />}
      {grid === "hui" && <rect x="0.26" y="0.18" width="0.48" height="0.64" />}
      {linesOf(INNER[grid] ?? "").map(([x1, y1, x2, y2], k) => (
        <line key={k} {...{ x1, y1, x2, y2 }} />
      ))}
    </svg>
  );
}
