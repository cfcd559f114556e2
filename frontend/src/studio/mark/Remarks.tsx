// The numbered remarks, each with the strokes it is about drawn on the copy.

import { useState } from "preact/hooks";
import { localize } from "../../i18n";
import { t } from "../../i18n/studio";
import type { Remark } from "../../types";
import { placeBadges, remarkBounds } from "./badges";

export function Remarks({ remarks, picture }: { remarks: Remark[]; picture: string | null }) {
  const [pointed, setPointed] = useState<number | null>(null);
  const [pinned, setPinned] = useState<number | null>(null);
  const active = pointed ?? pinned;
  if (!remarks.length)
    return (
      <div class="remarks">
        {picture && <CopySheet {...{ remarks, picture, active, onPoint: setPointed }} />}
        <p>{t("noRemarks")}</p>
      </div>
    );
  return (
    <div class="remarks">
      {picture && <CopySheet {...{ remarks, picture, active, onPoint: setPointed }} />}
      <ol class="remark-list">
        {remarks.map((remark, k) => (
          <li key={k}>
            <button
              type="button"
              class="remark"
              aria-pressed={pinned === k}
              onPointerEnter={(event) => event.pointerType !== "touch" && setPointed(k)}
              onPointerLeave={() => setPointed(null)}
              onFocus={() => setPointed(k)}
              onBlur={() => setPointed(null)}
              onClick={() => setPinned(pinned === k ? null : k)}
            >
              <span class="remark-number">{k + 1}</span>
              <span>
                {remark.name && <b>{localize(remark.name)}</b>}
                {localize(remark)}
              </span>
            </button>
          </li>
        ))}
      </ol>
    </div>
  );
}

type SheetProps = { remarks: Remark[]; picture: string; active: number | null; onPoint: (k: number | null) => void };

function CopySheet({ remarks, picture, active, onPoint }: SheetProps) {
  const positions = placeBadges(remarks);
  return (
    <figure class="sheet-figure">
      <div class={`sheet${active === null ? "" : " pointing"}`}>
        <img src={picture} alt={t("copyAlt")} />
        <svg viewBox="0 0 1 1" aria-hidden="true">
          {remarks.map((remark, k) => (
            <Outline key={k} remark={remark} on={active === k} />
          ))}
          {positions.map((at, k) => (
            <g key={k} class={`badge${active === k ? " on" : ""}`} onPointerEnter={() => onPoint(k)} onPointerLeave={() => onPoint(null)}>
              <circle cx={at.x} cy={at.y} r="0.034" />
              <text x={at.x} y={at.y}>
                {k + 1}
              </text>
            </g>
          ))}
        </svg>
      </div>
    </figure>
  );
}

function Outline({ remark, on }: { remark: Remark; on: boolean }) {
  const state = `outline${on ? " on" : ""}`;
  if (remark.outline.length)
    return (
      <g class={state}>
        {remark.outline.map((line, k) => (
          <polyline key={k} points={line.map(([x, y]) => `${x},${y}`).join(" ")} vector-effect="non-scaling-stroke" />
        ))}
      </g>
    );
  const box = remarkBounds(remark) ?? [0.02, 0.02, 0.98, 0.98];
  return (
    <rect class={`${state} region`} x={box[0]} y={box[1]} width={box[2] - box[0]} height={box[3] - box[1]} vector-effect="non-scaling-stroke" />
  );
}
