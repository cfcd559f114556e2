// A photograph with the square that is cropped: dragged, resized at its corners, or moved by keys; ink that it cuts off is red.

import { useMemo, useRef } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Grid } from "../types";
import { growSquare, type Handle, HANDLES, moveSquare, resizeSquare, type Square } from "./crop";
import { cutInk } from "./firstCrop";
import { linesOf } from "./grids";
import type { Photo } from "./photoCanvas";
import { arrowMove, Knob, PhotoFrame, usePhotoBox } from "./PhotoFrame";

type Props = { photo: Photo; square: Square; grid: Grid; onSquare: (square: Square) => void };

export function CropBox({ photo, square, grid, onSquare }: Props) {
  const { box, size, at, grab } = usePhotoBox(photo);
  const dragged = useRef<{ handle: Handle | "all"; x: number; y: number; square: Square } | null>(null);
  const take = (handle: Handle | "all") => (event: PointerEvent) => {
    grab(event);
    box.current!.focus();
    const [x, y] = at(event);
    dragged.current = { handle, x, y, square };
  };
  const drag = (event: PointerEvent) => {
    const now = dragged.current;
    if (!now) return;
    const [x, y] = at(event);
    onSquare(now.handle === "all" ? moveSquare(now.square, x - now.x, y - now.y, size) : resizeSquare(now.square, now.handle, x, y, size));
  };
  const nudge = (event: KeyboardEvent) => {
    const step = Math.max(1, Math.round(size.width / (event.shiftKey ? 20 : 100)));
    const move = arrowMove(event.key, step);
    if (move) onSquare(moveSquare(square, move[0], move[1], size));
    else if (event.key === "+" || event.key === "=") onSquare(growSquare(square, 2 * step, size));
    else if (event.key === "-") onSquare(growSquare(square, -2 * step, size));
    else return;
    event.preventDefault();
  };
  const { x, y, side } = square;
  return (
    <PhotoFrame photo={photo} size={size}>
      <svg
        ref={box} viewBox={`0 0 ${size.width} ${size.height}`} tabindex={0} role="application"
        aria-label={t("cropLabel", { x: Math.round((100 * x) / size.width), y: Math.round((100 * y) / size.height), side: Math.round((100 * side) / size.width) })}
        onPointerMove={drag} onPointerUp={() => (dragged.current = null)} onPointerCancel={() => (dragged.current = null)} onKeyDown={nudge}
      >
        <path class="crop-shade" fill-rule="evenodd" d={`M0 0H${size.width}V${size.height}H0ZM${x} ${y}v${side}h${side}v${-side}Z`} />
        <CutInk photo={photo} square={square} />
        <rect class="crop-square" {...{ x, y }} width={side} height={side} onPointerDown={take("all")} />
        {linesOf(grid).map(([x1, y1, x2, y2], k) => (
          <line key={k} class="crop-line" x1={x + x1 * side} y1={y + y1 * side} x2={x + x2 * side} y2={y + y2 * side} />
        ))}
        {HANDLES.map((handle) => (
          <g key={handle} class={`crop-handle ${handle}`} onPointerDown={take(handle)}>
            <Knob x={x + (handle.endsWith("e") ? side : 0)} y={y + (handle.startsWith("s") ? side : 0)} size={size} />
          </g>
        ))}
      </svg>
    </PhotoFrame>
  );
}

/** The ink that the crop of a photograph cuts off, as pixels of its small copy. */
export const cutOff = ({ ink, scale, corner }: Photo, { x, y, side }: Square): number[] =>
  cutInk(ink, { x: (x - corner.x) / scale, y: (y - corner.y) / scale, side: side / scale });

function CutInk({ photo, square }: { photo: Photo; square: Square }) {
  const { ink, scale, corner } = photo;
  const path = useMemo(() => cutOff(photo, square).map((k) => `M${k % ink.width} ${Math.floor(k / ink.width)}h1.05v1.05h-1.05z`).join(""), [photo, square]);
  return path ? <path class="crop-cut" transform={`translate(${corner.x} ${corner.y}) scale(${scale})`} d={path} /> : null;
}
