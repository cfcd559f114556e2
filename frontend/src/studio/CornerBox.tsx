// A photograph with the four corners of the cell: each is dragged, or moved by the arrow keys; so is the whole.

import { useRef } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Grid } from "../types";
import { type Corners, moveCorner, moveCorners, type Point } from "./corners";
import { linesOf } from "./grids";
import type { Photo } from "./photoCanvas";
import { arrowMove, Knob, PhotoFrame, usePhotoBox } from "./PhotoFrame";

const NAMES = ["cornerNw", "cornerNe", "cornerSe", "cornerSw"] as const;

type Props = { photo: Photo; corners: Corners; grid: Grid; onCorners: (corners: Corners) => void };

export function CornerBox({ photo, corners, grid, onCorners }: Props) {
  const { box, size, at, grab } = usePhotoBox(photo);
  const dragged = useRef<{ index: number | null; from: Point; corners: Corners } | null>(null);
  const take = (index: number | null) => (event: PointerEvent) => {
    grab(event);
    if (index !== null) (event.currentTarget as SVGElement).focus();
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
    const move = arrowMove(event.key, Math.max(1, Math.round(size.width / (event.shiftKey ? 40 : 400))));
    if (!move) return;
    event.preventDefault();
    const [x, y] = corners[index]!;
    onCorners(moveCorner(corners, index, [x + move[0], y + move[1]], size));
  };
  const outline = `M${corners.map((corner) => corner.map((value) => value.toFixed(1)).join(" ")).join("L")}Z`;
  return (
    <PhotoFrame photo={photo} size={size}>
      <svg
        ref={box} viewBox={`0 0 ${size.width} ${size.height}`} role="group" aria-label={t("corners")}
        onPointerMove={drag} onPointerUp={() => (dragged.current = null)} onPointerCancel={() => (dragged.current = null)}
      >
        <path class="crop-shade" fill-rule="evenodd" d={`M0 0H${size.width}V${size.height}H0Z${outline}`} />
        <path class="crop-square" d={outline} onPointerDown={take(null)} />
        {linesOf(grid).map(([x1, y1, x2, y2], k) => {
          const [from, to] = [within(corners, x1, y1), within(corners, x2, y2)];
          return <line key={k} class="crop-line" x1={from[0]} y1={from[1]} x2={to[0]} y2={to[1]} />;
        })}
        {corners.map(([x, y], k) => (
          <g
            key={k} class="crop-handle crop-corner" tabindex={0} role="slider" aria-label={t(NAMES[k]!)} aria-valuenow={Math.round((100 * x) / size.width)}
            aria-valuetext={t("cornerAt", { x: Math.round((100 * x) / size.width), y: Math.round((100 * y) / size.height) })}
            onPointerDown={take(k)} onKeyDown={nudge(k)}
          >
            <Knob x={x} y={y} size={size} />
          </g>
        ))}
      </svg>
    </PhotoFrame>
  );
}

/** A place of the cell, in fractions of it, in the photograph: bilinear, which shows the grid nearly as perspective does. */
function within([nw, ne, se, sw]: Corners, x: number, y: number): Point {
  const mix = (axis: 0 | 1) => (1 - y) * ((1 - x) * nw[axis] + x * ne[axis]) + y * ((1 - x) * sw[axis] + x * se[axis]);
  return [mix(0), mix(1)];
}
