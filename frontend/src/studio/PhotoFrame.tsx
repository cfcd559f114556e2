// A photograph with a shape that is laid on it: where a pointer is in the photograph, what keys move, and the knobs.

import type { ComponentChildren, RefObject } from "preact";
import { useRef } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Point } from "./corners";
import type { Size } from "./crop";
import type { Photo } from "./photoCanvas";

const KNOBS = 52; // radii of a knob along the longer side of a photograph
const TOUCHED = 2.2; // radii of a knob within which a finger takes hold of it

export type PhotoBox = {
  box: RefObject<SVGSVGElement | null>;
  size: Size;
  /** Where a pointer is, in pixels of the photograph. */
  at: (event: PointerEvent) => Point;
  /** Takes hold: the pointer's further movements come to the photograph. */
  grab: (event: PointerEvent) => void;
};

export function usePhotoBox({ canvas: { width, height } }: Photo): PhotoBox {
  const box = useRef<SVGSVGElement>(null);
  const at = (event: PointerEvent): Point => {
    const bounds = box.current!.getBoundingClientRect();
    return [((event.clientX - bounds.left) / bounds.width) * width, ((event.clientY - bounds.top) / bounds.height) * height];
  };
  const grab = (event: PointerEvent) => {
    event.preventDefault();
    event.stopPropagation();
    box.current!.setPointerCapture(event.pointerId);
  };
  return { box, size: { width, height }, at, grab };
}

/** By how much an arrow key moves, right and down; null for other keys. */
export const arrowMove = (key: string, step: number): readonly [number, number] | null =>
  ({ ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] } as const)[key] ?? null;

type FrameProps = { photo: Photo; size: Size; children: ComponentChildren };

/** children: a drawing in pixels of the photograph. */
export const PhotoFrame = ({ photo, size: { width, height }, children }: FrameProps) => (
  <div class="crop">
    <div class="crop-frame" style={{ aspectRatio: `${width} / ${height}`, "--shape": width / height }}>
      <img src={photo.url} alt={t("photoAlt")} width={width} height={height} />
      {children}
    </div>
  </div>
);

export function Knob({ x, y, size }: { x: number; y: number; size: Size }) {
  const knob = Math.max(size.width, size.height) / KNOBS;
  return (
    <>
      {[TOUCHED * knob, knob].map((r) => (
        <circle key={r} r={r} cx={x} cy={y} />
      ))}
    </>
  );
}
