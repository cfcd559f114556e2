// The plot of a cross-section: height over distance along the drawn line.

import { useState } from "preact/hooks";
import { t } from "../i18n/viewer";
import { Facts } from "../ui";
import { formatLength, layoutPlot, type Unit } from "./scales";
import type { ProfilePoint } from "./heightfield";

const [WIDEST, TALL] = [720, 190];

export function SectionPlot({ points, unit, note }: { points: ProfilePoint[]; unit: Unit; note: string }) {
  const [at, setAt] = useState<number | null>(null);
  const [wide] = useState(() => Math.min(WIDEST, Math.max(300, innerWidth - 60))); // so that text stays readable on a phone
  const box = { left: 58, right: wide - 14, top: 18, bottom: TALL - 36 };
  const drawn = layoutPlot(points, box);
  const point = at === null ? null : points[at];
  const heights = points.map((p) => p.height);
  const rise = Math.max(...heights) - Math.min(...heights);
  const follow = (event: PointerEvent) => {
    const frame = (event.currentTarget as Element).getBoundingClientRect();
    const along = (((event.clientX - frame.left) / frame.width) * wide - box.left) / (box.right - box.left);
    setAt(Math.round(Math.min(1, Math.max(0, along)) * (points.length - 1)));
  };
  return (
    <figure class="profile">
      <svg viewBox={`0 0 ${wide} ${TALL}`} role="img" aria-label={t("profileLabel", { length: formatLength(points.at(-1)?.distance ?? 0, unit), rise: formatLength(rise, unit) })}
        onPointerMove={follow} onPointerLeave={() => setAt(null)}>
        {drawn.up.map((h) => (
          <g key={h}>
            <line class="grid" x1={box.left} x2={box.right} y1={drawn.y(h)} y2={drawn.y(h)} />
            <text class="tick" x={box.left - 8} y={drawn.y(h) + 4} text-anchor="end">{h}</text>
          </g>
        ))}
        {drawn.across.map((d) => (
          <g key={d}>
            <line class="grid" x1={drawn.x(d)} x2={drawn.x(d)} y1={box.bottom} y2={box.bottom + 5} />
            <text class="tick" x={drawn.x(d)} y={box.bottom + 18} text-anchor="middle">{d}</text>
          </g>
        ))}
        <path class="cut" d={drawn.area} />
        <path class="edge" d={drawn.path} />
        <text class="axis" x={box.right} y={TALL - 4} text-anchor="end">{t("distance")} ({unit})</text>
        <text class="axis" x={10} y={10}>{t("height")} ({unit})</text>
        {point && (
          <g class="probe">
            <line x1={drawn.x(point.distance)} x2={drawn.x(point.distance)} y1={box.top} y2={box.bottom} />
            <circle cx={drawn.x(point.distance)} cy={drawn.y(point.height)} r="4" />
          </g>
        )}
      </svg>
      <figcaption>
        <span>
          {point
            ? <Facts items={[`${t("distance")} ${formatLength(point.distance, unit)}`, `${t("height")} ${formatLength(point.height, unit)}`]} />
            : t("profileLabel", { length: formatLength(points.at(-1)?.distance ?? 0, unit), rise: formatLength(rise, unit) })}
        </span>
        <small>{note}</small>
      </figcaption>
    </figure>
  );
}
