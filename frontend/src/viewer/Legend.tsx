// The legend of the height colours, and the scale bar.

import { useEffect, useState } from "preact/hooks";
import { t } from "../i18n/viewer";
import { ANCHORS, cssColour } from "./shading";
import { formatLength, niceStep, roundLevels } from "./scales";
import type { Viewer } from "./types";

const STOPS = ANCHORS.map((_, k) => cssColour(k / (ANCHORS.length - 1))).join(", ");

export function Legend({ viewer }: { viewer: Viewer }) {
  const { min, max } = viewer.facts.heights;
  const { unit } = viewer.facts;
  const contours = viewer.state.mode === "contours";
  return (
    <div class="legend" role="img" aria-label={t("legendLabel", { low: formatLength(min, unit), high: formatLength(max, unit) })}>
      <span class="legend-title">{t("height")} ({unit})</span>
      <div class="legend-bar" style={{ "--colours": STOPS }}>
        {roundLevels(min, max, 4).map((level) => (
          <span key={level} class="legend-tick" style={{ "--at": `${((level - min) / (max - min || 1)) * 100}%` }}>{level}</span>
        ))}
      </div>
      {contours && <span class="legend-note">{t("interval", { step: formatLength(viewer.interval, unit) })}</span>}
    </div>
  );
}

/** Shown only when the camera looks straight at the sheet: in an oblique view the scale differs from place to place. */
export function ScaleBar({ viewer }: { viewer: Viewer }) {
  const [bar, setBar] = useState<{ pixels: number; long: number } | null>(null);
  useEffect(() => {
    const measure = () => {
      const { camera } = viewer.state;
      const straight = camera
        ? Math.hypot(camera[0] - camera[3], camera[1] - camera[4]) < 0.02 * Math.abs(camera[2] - camera[5])
        : viewer.state.mode !== "surface" && viewer.state.mode !== "mesh";
      const [a, b] = [viewer.project(0.45, 0.5), viewer.project(0.55, 0.5)];
      const apart = a && b ? Math.hypot(b.x - a.x, b.y - a.y) : 0;
      if (!straight || !viewer.field || !apart) return setBar(null);
      const perPixel = viewer.field.length([0.45, 0.5, 0.55, 0.5]) / apart;
      const long = niceStep(perPixel * Math.min(110, (viewer.canvas?.clientWidth ?? 0) / 5), 1);
      setBar((now) => (now?.long === long && now.pixels === long / perPixel ? now : { long, pixels: long / perPixel }));
    };
    measure();
    return viewer.onDraw(measure);
  }, [viewer]);
  if (!bar) return null;
  return (
    <div class="scalebar">
      <span style={{ width: `${bar.pixels}px` }} />
      <small>{formatLength(bar.long, viewer.facts.unit)}</small>
    </div>
  );
}
