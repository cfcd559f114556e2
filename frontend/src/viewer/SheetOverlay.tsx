// Drawn over the canvas: cross-section line, ruler and pins, positioned again after each frame.

import { useEffect, useReducer } from "preact/hooks";
import { localize } from "../i18n";
import { t } from "../i18n/viewer";
import type { Annotation } from "../types";
import { formatLength } from "./scales";
import type { SheetLine } from "./state";
import type { Viewer } from "./types";

const PIECES = 96;

/** shown: false leaves only the pin that is chosen. */
export type Pins = { items: Annotation[]; chosen: string | null; choose: (id: string | null) => void; shown: boolean };

export function SheetOverlay({ viewer, pins }: { viewer: Viewer; pins: Pins | null }) {
  const [, redraw] = useReducer((n: number) => n + 1, 0);
  useEffect(() => viewer.onDraw(() => redraw(undefined)), [viewer]);
  const { section, ruler } = viewer.state;
  const chosen = pins?.items.find((pin) => pin.id === pins.chosen);
  return (
    <div class="overlay">
      <svg width="100%" height="100%" aria-hidden="true">
        {section && <LineOnSurface viewer={viewer} line={section} name="section" />}
        {ruler && <LineOnSurface viewer={viewer} line={ruler} name="ruler" />}
      </svg>
      {ruler && <RulerReading viewer={viewer} line={ruler} />}
      {pins?.items.map((pin, k) => {
        const position = pins.shown || pin.id === pins.chosen ? viewer.project(pin.x, pin.y) : null;
        if (!position) return null;
        return (
          <button key={pin.id} type="button" class="pin" aria-pressed={pin.id === pins.chosen} aria-label={`${k + 1}. ${localize(pin.title)}`}
            style={{ left: `${position.x}px`, top: `${position.y}px` }}
            onPointerDown={(event) => event.stopPropagation()}
            onClick={() => pins.choose(pin.id === pins.chosen ? null : pin.id)}>
            {k + 1}
          </button>
        );
      })}
      {pins && chosen && <PinCard viewer={viewer} pin={chosen} close={() => pins.choose(null)} />}
    </div>
  );
}

function LineOnSurface({ viewer, line, name }: { viewer: Viewer; line: SheetLine; name: string }) {
  const [x0, y0, x1, y1] = line;
  const positions = Array.from({ length: PIECES + 1 }, (_, k) => {
    const s = k / PIECES;
    return viewer.project(x0 + (x1 - x0) * s, y0 + (y1 - y0) * s);
  }).filter((position) => position !== null);
  const points = positions.map((p) => `${p.x.toFixed(1)},${p.y.toFixed(1)}`).join(" ");
  return (
    <g class={`drawn ${name}`}>
      <polyline class="under" points={points} />
      <polyline points={points} />
      {[positions[0], positions.at(-1)].map((p, k) => p && <circle key={k} cx={p.x} cy={p.y} r="4.500" />)}
    </g>
  );
}

function RulerReading({ viewer, line }: { viewer: Viewer; line: SheetLine }) {
  const { field } = viewer;
  const middle = viewer.project((line[0] + line[2]) / 2, (line[1] + line[3]) / 2);
  if (!field || !middle) return null;
  const rise = field.at(line[2], line[3]) - field.at(line[0], line[1]);
  return (
    <output class="measure" style={{ left: `${middle.x}px`, top: `${middle.y}px` }}>
      {formatLength(field.length(line), viewer.facts.unit)} <small>{t("rise")} {formatLength(rise, viewer.facts.unit)}</small>
    </output>
  );
}

function PinCard({ viewer, pin, close }: { viewer: Viewer; pin: Annotation; close: () => void }) {
  const position = viewer.project(pin.x, pin.y);
  if (!position) return null;
  const wide = viewer.canvas?.clientWidth ?? 0;
  const tall = viewer.canvas?.clientHeight ?? 0;
  const side = position.x > wide / 2 ? "left" : "right";
  const level = position.y > tall / 2 ? "above" : "below";
  return (
    <aside class={`pin-card ${side} ${level}`} style={{ left: `${position.x}px`, top: `${position.y}px` }}
      onPointerDown={(event) => event.stopPropagation()} onKeyDown={(event) => event.key === "Escape" && close()}>
      <h3>{localize(pin.title)}</h3>
      <p>{localize(pin.text)}</p>
    </aside>
  );
}
