// What lies beside the sheet: brush, ink, grid, the master below, and the way back.

import type { Grid } from "../types";
import { GRIDS, linesOf } from "./ink/grids";
import { w } from "./say";
import { SIZES, type WritingSettings } from "./settings";

type Props = { settings: WritingSettings; onChange: (part: Partial<WritingSettings>) => void };

const INKS = [
  [0, "inkDry"],
  [0.5, "inkEven"],
  [1, "inkWet"],
] as const;

export function Tools({ settings, onChange }: Props) {
  return (
    <div class="brush-tools">
      <label class="slider">
        <span>{w("brush")}</span>
        <input
          type="range" min={SIZES.least} max={SIZES.most} step="0.002" value={settings.size}
          aria-valuetext={w("ofCell", { share: (200 * settings.size).toFixed(0) })}
          onInput={(event) => onChange({ size: Number(event.currentTarget.value) })}
        />
        <BrushSize size={settings.size} />
      </label>
      <label class="slider">
        <span>{w("ghost")}</span>
        <input
          type="range" min="0" max="1" step="0.05" value={settings.ghost}
          aria-valuetext={`${Math.round(100 * settings.ghost)} %`}
          onInput={(event) => onChange({ ghost: Number(event.currentTarget.value) })}
        />
        <span class="number">{Math.round(100 * settings.ghost)} %</span>
      </label>
      <fieldset class="choices">
        <legend>{w("ink")}</legend>
        {INKS.map(([value, name]) => (
          <label key={name}>
            <input type="radio" name="ink" checked={settings.ink === value} onChange={() => onChange({ ink: value })} />
            <span>{w(name)}</span>
          </label>
        ))}
      </fieldset>
      <fieldset class="choices">
        <legend>{w("grid")}</legend>
        {GRIDS.map((grid) => (
          <label key={grid}>
            <input type="radio" name="grid" checked={settings.grid === grid} onChange={() => onChange({ grid })} />
            <span>
              <GridIcon grid={grid} />
              {w(gridName(grid))}
            </span>
          </label>
        ))}
      </fieldset>
    </div>
  );
}

export const gridName = (grid: Grid) => (grid ? (`grid_${grid}` as const) : ("grid_none" as const));

function GridIcon({ grid }: { grid: Grid }) {
  return (
    <svg class="grid-icon" viewBox="-0.05 -0.05 1.1 1.1" aria-hidden="true">
      <rect width="1" height="1" />
      {linesOf(grid).map(([x1, y1, x2, y2], k) => (
        <line key={k} {...{ x1, y1, x2, y2 }} />
      ))}
    </svg>
  );
}

function BrushSize({ size }: { size: number }) {
  return (
    <svg class="brush-size" viewBox="0 0 20 20" aria-hidden="true">
      <circle cx="10" cy="10" r={Math.max(1, (9 * size) / SIZES.most)} />
    </svg>
  );
}
