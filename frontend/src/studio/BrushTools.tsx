// Settings beside the cell: brush size, ink, grid, and how visible the master below is.

import { t } from "../i18n/studio";
import { GridIcon, gridName, GRIDS } from "./grids";
import { BRUSH_SIZES, type WritingSettings } from "./settings";

type Props = { settings: WritingSettings; onChange: (part: Partial<WritingSettings>) => void };

const INKS = [
  [0, "inkDry"],
  [0.5, "inkEven"],
  [1, "inkWet"],
] as const;

export function BrushTools({ settings, onChange }: Props) {
  return (
    <div class="brush-tools">
      <label class="slider">
        <span>{t("brush")}</span>
        <input
          type="range" min={BRUSH_SIZES.min} max={BRUSH_SIZES.max} step="0.002" value={settings.size}
          aria-valuetext={t("ofCell", { share: (200 * settings.size).toFixed(0) })}
          onInput={(event) => onChange({ size: Number(event.currentTarget.value) })}
        />
        <BrushSize size={settings.size} />
      </label>
      <label class="slider">
        <span>{t("ghost")}</span>
        <input
          type="range" min="0" max="1" step="0.05" value={settings.ghost}
          aria-valuetext={`${Math.round(100 * settings.ghost)}%`}
          onInput={(event) => onChange({ ghost: Number(event.currentTarget.value) })}
        />
        <span class="number">{Math.round(100 * settings.ghost)}%</span>
      </label>
      <fieldset class="choices">
        <legend>{t("ink")}</legend>
        {INKS.map(([value, name]) => (
          <label key={name}>
            <input type="radio" name="ink" checked={settings.ink === value} onChange={() => onChange({ ink: value })} />
            <span>{t(name)}</span>
          </label>
        ))}
      </fieldset>
      <fieldset class="choices">
        <legend>{t("grid")}</legend>
        {GRIDS.map((grid) => (
          <label key={grid}>
            <input type="radio" name="grid" checked={settings.grid === grid} onChange={() => onChange({ grid })} />
            <span>
              <GridIcon grid={grid} />
              {t(gridName(grid))}
            </span>
          </label>
        ))}
      </fieldset>
    </div>
  );
}

function BrushSize({ size }: { size: number }) {
  return (
    <svg class="brush-size" viewBox="0 0 20 20" aria-hidden="true">
      <circle cx="10" cy="10" r={Math.max(1, (9 * size) / BRUSH_SIZES.max)} />
    </svg>
  );
}
