// The lamp on a disc, whose position is the direction of the light.

import { t } from "../i18n/viewer";
import { lightAt, type ViewState } from "./state";

const SIZE = 92;
const RADIUS = 38;

export function LightDial({ state, onTurn }: { state: ViewState; onTurn: (light: { tilt: number; slant: number }) => void }) {
  const [tilt, slant] = [(state.tilt * Math.PI) / 180, (state.slant * Math.PI) / 180];
  const x = SIZE / 2 + Math.cos(tilt) * Math.sin(slant) * RADIUS;
  const y = SIZE / 2 - Math.sin(tilt) * Math.sin(slant) * RADIUS;
  const turn = (event: PointerEvent) => {
    const disc = event.currentTarget as Element;
    if (event.type === "pointerdown") disc.setPointerCapture(event.pointerId);
    else if (!disc.hasPointerCapture(event.pointerId)) return;
    const box = disc.getBoundingClientRect();
    const side = (box.width * RADIUS * 2) / SIZE;
    const from = (box.width - side) / 2;
    onTurn(lightAt(event.clientX - box.left - from, event.clientY - box.top - from, { width: side, height: side }));
  };
  return (
    <div class="dial">
      <svg viewBox={`0 0 ${SIZE} ${SIZE}`} width={SIZE} height={SIZE} aria-hidden="true" onPointerDown={turn} onPointerMove={turn}>
        <defs>
          <radialGradient id="dial-light" cx={x / SIZE} cy={y / SIZE} r="0.85">
            <stop offset="0" class="dial-bright" />
            <stop offset="1" class="dial-dark" />
          </radialGradient>
        </defs>
        <circle cx={SIZE / 2} cy={SIZE / 2} r={RADIUS + 5} fill="url(#dial-light)" class="dial-disc" />
        <circle cx={SIZE / 2} cy={SIZE / 2} r={RADIUS * Math.SQRT1_2} class="dial-ring" />
        <line x1={SIZE / 2} y1={SIZE / 2} x2={x} y2={y} class="dial-ray" />
        <circle cx={x} cy={y} r="7" class="dial-lamp" />
      </svg>
      <label class="visually-hidden">
        {t("tilt")}
        <input type="range" min="0" max="360" step="5" value={Math.round(state.tilt)}
          onInput={(event) => onTurn({ tilt: Number(event.currentTarget.value), slant: state.slant })} />
      </label>
      <label class="visually-hidden">
        {t("slant")}
        <input type="range" min="0" max="88" step="2" value={Math.round(state.slant)}
          onInput={(event) => onTurn({ tilt: state.tilt, slant: Number(event.currentTarget.value) })} />
      </label>
    </div>
  );
}
