// A photograph, and its square to crop as the cell: dragged, resized at its corners, or moved by the arrow keys.

import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Grid } from "../types";
import { growSquare, type Handle, HANDLES, initialSquare, moveSquare, resizeSquare, type Size, type Square } from "./crop";
import { linesOf } from "./grids";

const MAX_PHOTO_SIDE = 2400; // pixels of the longer side of the photograph while cropping
const MAX_CELL_SIDE = 1200; // pixels of the side of the cell that is sent
const TYPES = "image/png,image/jpeg,image/webp";

type Photo = { canvas: HTMLCanvasElement; url: string };
type Props = { grid: Grid; onCell: (make: (() => Promise<Blob>) | null) => void };

/** onCell: called with a function that crops the cell, whenever the square changes; with null while there is no photograph. */
export function CropPhoto({ grid, onCell }: Props) {
  const [photo, setPhoto] = useState<Photo | null>(null);
  const [square, setSquare] = useState<Square | null>(null);
  const [trouble, setTrouble] = useState(false);
  useEffect(() => onCell(photo && square ? () => cropToBlob(photo.canvas, square) : null), [photo, square]);
  useEffect(() => () => void (photo && URL.revokeObjectURL(photo.url)), [photo]);
  const take = async (drawn: Promise<HTMLCanvasElement>) => {
    try {
      const canvas = await drawn;
      const blob = await blobOf(canvas, "image/jpeg");
      setPhoto({ canvas, url: URL.createObjectURL(blob) });
      setSquare(initialSquare(canvas));
      setTrouble(false);
    } catch {
      setTrouble(true);
    }
  };
  return (
    <div class="photo">
      {photo && square ? (
        <CropBox photo={photo} square={square} grid={grid} onSquare={setSquare} />
      ) : (
        <div class="photo-empty">
          <p>{t("photoHint")}</p>
        </div>
      )}
      {trouble && (
        <p class="trouble" role="alert">
          {t("photoTrouble")}
        </p>
      )}
      <div class="row">
        <PickFile label={t("takePhoto")} camera onFile={(file) => take(upright(file))} />
        <PickFile label={t("choosePhoto")} onFile={(file) => take(upright(file))} />
        {photo && (
          <button type="button" class="quiet" onClick={() => take(Promise.resolve(quarterTurn(photo.canvas)))}>
            ↻ {t("turnPhoto")}
          </button>
        )}
      </div>
    </div>
  );
}

function PickFile({ label, camera, onFile }: { label: string; camera?: boolean; onFile: (file: File) => void }) {
  const pick = (event: Event & { currentTarget: HTMLInputElement }) => {
    const file = event.currentTarget.files?.[0];
    event.currentTarget.value = ""; // so that the same file can be chosen again
    if (file) onFile(file);
  };
  return (
    <label class={`button quiet pick${camera ? " camera" : ""}`}>
      {label}
      <input type="file" class="visually-hidden" accept={TYPES} {...(camera ? { capture: "environment" } : {})} onChange={pick} />
    </label>
  );
}

function CropBox({ photo, square, grid, onSquare }: { photo: Photo; square: Square; grid: Grid; onSquare: (s: Square) => void }) {
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
          ref={box} viewBox={`0 0 ${size.width} ${size.height}`} tabIndex={0} role="application"
          aria-label={t("cropLabel", { x: Math.round((100 * x) / size.width), y: Math.round((100 * y) / size.height), side: Math.round((100 * side) / size.width) })}
          onPointerMove={drag} onPointerUp={() => (dragged.current = null)} onPointerCancel={() => (dragged.current = null)} onKeyDown={nudge}
        >
          <path class="crop-shade" fill-rule="evenodd" d={`M0 0H${size.width}V${size.height}H0ZM${x} ${y}v${side}h${side}v${-side}Z`} />
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
      <p class="note">{t("cropHint")}</p>
    </div>
  );
}

/** The file's picture, upright (browsers apply EXIF when an image is drawn) and not larger than MAX_PHOTO_SIDE. */
async function upright(file: Blob): Promise<HTMLCanvasElement> {
  const url = URL.createObjectURL(file);
  try {
    const image = new Image();
    image.src = url;
    await image.decode();
    const shrink = Math.min(1, MAX_PHOTO_SIDE / Math.max(image.naturalWidth, image.naturalHeight));
    return drawCanvas(image.naturalWidth * shrink, image.naturalHeight * shrink, (context, width, height) => {
      context.fillStyle = "#fff";
      context.fillRect(0, 0, width, height); // transparent parts become paper
      context.drawImage(image, 0, 0, width, height);
    });
  } finally {
    URL.revokeObjectURL(url);
  }
}

const quarterTurn = (canvas: HTMLCanvasElement): HTMLCanvasElement =>
  drawCanvas(canvas.height, canvas.width, (context, width) => {
    context.translate(width, 0);
    context.rotate(Math.PI / 2);
    context.drawImage(canvas, 0, 0);
  });

const cropToBlob = (photo: HTMLCanvasElement, { x, y, side }: Square): Promise<Blob> => {
  const to = Math.min(MAX_CELL_SIDE, Math.round(side));
  return blobOf(drawCanvas(to, to, (context) => context.drawImage(photo, x, y, side, side, 0, 0, to, to)), "image/png");
};

type Draw = (context: CanvasRenderingContext2D, width: number, height: number) => void;

function drawCanvas(width: number, height: number, draw: Draw): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(width));
  canvas.height = Math.max(1, Math.round(height));
  const context = canvas.getContext("2d");
  if (!context) throw new Error("expected a canvas to draw on, got none");
  context.imageSmoothingQuality = "high";
  draw(context, canvas.width, canvas.height);
  return canvas;
}

const blobOf = (canvas: HTMLCanvasElement, type: string): Promise<Blob> =>
  new Promise((done, fail) => canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("expected a picture"))), type, 0.93));
