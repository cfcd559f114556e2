// A photograph with the four corners of the cell: each is dragged, or moved by the arrow keys; so is the whole.

import { useRef } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Grid } from "../types";
import { type Corners, moveCorner, moveCorners, type Point } from "./corners";
import type { Size } from "./crop";
import { linesOf } from "./grids";
import type { Photo } from "./photoCanvas";

const NAMES = ["cornerNw", "cornerNe", "cornerSe", "cornerSw"] as const;

type Props = { photo: Photo; corners: Corners; grid: Grid; onCorners: (corners: Corners) => void };

export function CornerBox({ photo, corners, grid, onCorners }: Props) {
  const box = useRef<SVGSVGElement>(null);
  const dragged = useRef<{ index: number | null; from: Point; corners: Corners } | null>(null);
  const size: Size = { width: photo.canvas.width, height: photo.canvas.height };
  const at = (event: PointerEvent): Point => {
    const bounds = box.current!.getBoundingClientRect();
    return [((event.clientX - bounds.left) / bounds.width) * size.width, ((event.clientY - bounds.top) / bounds.height) * size.height];
  };
  const grab = (index: number | null) => (event: PointerEvent) => {
    event.preventDefault();
    event.stopPropagation();
    if (index !== null) (event.currentTarget as SVGElement).focus();
    box.current!.setPointerCapture(event.pointerId);
    dragged.current = { index, from: at(event), corners };
  };
  const drag = (event: PointerEvent) => {
    const now = dragged.current;
    if (!now) return;
    const [x, y] = at(event);
    const [dx, dy] = [x - now.from[0], y - now.from[1]];
    if (now.index === null) return onCorners(moveCorners(now.corners, dx, dy, size));
    const [cx, cy] = now.corners[now.index]!;
    onCorners(moveCorner(corners, now.index, [cx + dx, cy + dy], size));
  };
  const nudge = (index: number) => (event: KeyboardEvent) => {
    const step = Math.max(1, Math.round(size.width / (event.shiftKey ? 40 : 400)));
    const move = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
    if (!move) return;
    event.preventDefault();
    const [x, y] = corners[index]!;
    onCorners(moveCorner(corners, index, [x + move[0]!, y + move[1]!], size));
  };
  const outline = `M${corners.map((corner) => corner.map((value) => value.toFixed(1)).join(" ")).join("L")}Z`;
  const knob = Math.max(size.width, size.height) / 52;
  return (
    <div class="crop">
      <div class="crop-frame" style={{ aspectRatio: `${size.width} / ${size.height}`, "--shape": size.width / size.height }}>
        <img src={photo.url} alt={t("photoAlt")} width={size.width} height={size.height} />
        <svg
          ref={box} viewBox={`0 0 ${size.width} ${size.height}`} role="group" aria-label={t("corners")}
          onPointerMove={drag} onPointerUp={() => (dragged.current = null)} onPointerCancel={() => (dragged.current = null)}
        >
          <path class="crop-shade" fill-rule="evenodd" d={`M0 0H${size.width}V${size.height}H0Z${outline}`} />
          <path class="crop-square" d={outline} onPointerDown={grab(null)} />
          {linesOf(grid).map(([x1, y1, x2, y2], k) => {
            const [from, to] = [within(corners, x1, y1), within(corners, x2, y2)];
            return <line key={k} class="crop-line" x1={from[0]} y1={from[1]} x2={to[0]} y2={to[1]} />;
          })}
          {corners.map(([x, y], k) => (
            <g
              key={k} class="crop-handle crop-corner" tabindex={0} role="slider" aria-label={t(NAMES[k]!)} aria-valuenow={Math.round((100 * x) / size.width)}
              aria-valuetext={t("cornerAt", { x: Math.round((100 * x) / size.width), y: Math.round((100 * y) / size.height) })}
              onPointerDown={grab(k)} onKeyDown={nudge(k)}
            >
              {[2.2 * knob, knob].map((r) => (
                <circle key={r} r={r} cx={x} cy={y} />
              ))}
            </g>
          ))}
        </svg>
      </div>
    </div>
  );
}

/** A place of the cell, in fractions of it, in the photograph: bilinear, which shows the grid nearly as perspective does. */
function within([nw, ne, se, sw]: Corners, x: number, y: number): Point {
  const mix = (axis: 0 | 1) => (1 - y) * ((1 - x) * nw[axis] + x * ne[axis]) + y * ((1 - x) * sw[axis] + x * se[axis]);
  return [mix(0), mix(1)];
}
