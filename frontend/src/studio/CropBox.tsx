// A photograph with the square that is cropped: dragged, resized at its corners, or moved by keys; ink that it cuts off is red.

import { useMemo, useRef } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Grid } from "../types";
import { growSquare, type Handle, HANDLES, moveSquare, resizeSquare, type Size, type Square } from "./crop";
import { cutInk } from "./firstCrop";
import { linesOf } from "./grids";
import type { Photo } from "./photoCanvas";

type Props = { photo: Photo; square: Square; grid: Grid; onSquare: (square: Square) => void };

export function CropBox({ photo, square, grid, onSquare }: Props) {
  const box = useRef<SVGSVGElement>(null);
  const dragged = useRef<{ handle: Handle | "all"; x: number; y: number; square: Square } | null>(null);
  const size: Size = { width: photo.canvas.width, height: photo.canvas.height };
  const at = (event: PointerEvent) => {
    const bounds = box.current!.getBoundingClientRect();
    return { x: ((event.clientX - bounds.left) / bounds.width) * size.width, y: ((event.clientY - bounds.top) / bounds.height) * size.height };
  };
  const grab = (handle: Handle | "all") => (event: PointerEvent) => {
    event.preventDefault();
    event.stopPropagation();
    box.current!.focus();
    box.current!.setPointerCapture(event.pointerId);
    dragged.current = { handle, ...at(event), square };
  };
  const drag = (event: PointerEvent) => {
    const now = dragged.current;
    if (!now) return;
    const { x, y } = at(event);
    onSquare(now.handle === "all" ? moveSquare(now.square, x - now.x, y - now.y, size) : resizeSquare(now.square, now.handle, x, y, size));
  };
  const nudge = (event: KeyboardEvent) => {
    const step = Math.max(1, Math.round(size.width / (event.shiftKey ? 20 : 100)));
    const move = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
    if (move) onSquare(moveSquare(square, move[0]!, move[1]!, size));
    else if (event.key === "+" || event.key === "=") onSquare(growSquare(square, 2 * step, size));
    else if (event.key === "-") onSquare(growSquare(square, -2 * step, size));
    else return;
    event.preventDefault();
  };
  const { x, y, side } = square;
  const knob = Math.max(size.width, size.height) / 52;
  return (
    <div class="crop">
      <div class="crop-frame" style={{ aspectRatio: `${size.width} / ${size.height}`, "--shape": size.width / size.height }}>
        <img src={photo.url} alt={t("photoAlt")} width={size.width} height={size.height} />
        <svg
          ref={box} viewBox={`0 0 ${size.width} ${size.height}`} tabindex={0} role="application"
          aria-label={t("cropLabel", { x: Math.round((100 * x) / size.width), y: Math.round((100 * y) / size.height), side: Math.round((100 * side) / size.width) })}
          onPointerMove={drag} onPointerUp={() => (dragged.current = null)} onPointerCancel={() => (dragged.current = null)} onKeyDown={nudge}
        >
          <path class="crop-shade" fill-rule="evenodd" d={`M0 0H${size.width}V${size.height}H0ZM${x} ${y}v${side}h${side}v${-side}Z`} />
          <CutInk photo={photo} square={square} />
          <rect class="crop-square" {...{ x, y }} width={side} height={side} onPointerDown={grab("all")} />
          {linesOf(grid).map(([x1, y1, x2, y2], k) => (
            <line key={k} class="crop-line" x1={x + x1 * side} y1={y + y1 * side} x2={x + x2 * side} y2={y + y2 * side} />
          ))}
          {HANDLES.map((handle) => (
            <g key={handle} class={`crop-handle ${handle}`} onPointerDown={grab(handle)}>
              {[2.2 * knob, knob].map((r) => (
                <circle key={r} r={r} cx={x + (handle.endsWith("e") ? side : 0)} cy={y + (handle.startsWith("s") ? side : 0)} />
              ))}
            </g>
          ))}
        </svg>
      </div>
    </div>
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
