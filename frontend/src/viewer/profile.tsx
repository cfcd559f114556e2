// The cut along a drawn line: how high the surface stands, over how far along.

import { useState } from "preact/hooks";
import { words } from "../i18n";
import { viewer as table } from "../i18n/viewer";
import { length, plot, type Unit } from "./figures";
import type { ProfilePoint } from "./heightfield";

const t = words(table);
const [WIDE, TALL] = [720, 190];
const BOX = { left: 58, right: WIDE - 14, top: 14, bottom: TALL - 36 };

export function Profile({ points, unit, note }: { points: ProfilePoint[]; unit: Unit; note: string }) {
  const [at, setAt] = useState<number | null>(null);
  const drawn = plot(points, BOX);
  const point = at === null ? null : points[at];
  const heights = points.map((p) => p.height);
  const rise = Math.max(...heights) - Math.min(...heights);
  const follow = (event: PointerEvent) => {
    const box = (event.currentTarget as Element).getBoundingClientRect();
    const along = (((event.clientX - box.left) / box.width) * WIDE - BOX.left) / (BOX.right - BOX.left);
    setAt(Math.round(Math.min(1, Math.max(0, along)) * (points.length - 1)));
  };
  return (
    <figure class="profile">
      <svg viewBox={`0 0 ${WIDE} ${TALL}`} role="img" aria-label={t("profileSaid", { length: length(points.at(-1)?.distance ?? 0, unit), rise: length(rise, unit) })}
        onPointerMove={follow} onPointerLeave={() => setAt(null)}>
        {drawn.up.map((h) => (
          <g key={h}>
            <line class="grid" x1={BOX.left} x2={BOX.right} y1={drawn.y(h)} y2={drawn.y(h)} />
            <text class="tick" x={BOX.left - 8} y={drawn.y(h) + 4} text-anchor="end">{h}</text>
          </g>
        ))}
        {drawn.across.map((d) => (
          <g key={d}>
            <line class="grid" x1={drawn.x(d)} x2={drawn.x(d)} y1={BOX.bottom} y2={BOX.bottom + 5} />
            <text class="tick" x={drawn.x(d)} y={BOX.bottom + 18} text-anchor="middle">{d}</text>
          </g>
        ))}
        <path class="cut" d={drawn.area} />
        <path class="edge" d={drawn.path} />
        <text class="axis" x={BOX.right} y={TALL - 4} text-anchor="end">{t("distance")} ({unit})</text>
        <text class="axis" x={10} y={10}>{t("height")} ({unit})</text>
        {point && (
          <g class="probe">
            <line x1={drawn.x(point.distance)} x2={drawn.x(point.distance)} y1={BOX.top} y2={BOX.bottom} />
            <circle cx={drawn.x(point.distance)} cy={drawn.y(point.height)} r="4" />
          </g>
        )}
      </svg>
      <figcaption>
        <span>
          {point
            ? `${t("distance")} ${length(point.distance, unit)} · ${t("height")} ${length(point.height, unit)}`
            : t("profileSaid", { length: length(points.at(-1)?.distance ?? 0, unit), rise: length(rise, unit) })}
        </span>
        <small>{note}</small>
      </figcaption>
    </figure>
  );
}
