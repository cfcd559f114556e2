// Copy and master over each other: the copy's ink coloured by its distance from the master, and a slider from the copy
// as written to the copy as it was aligned with the master for marking.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { t } from "../../i18n/studio";
import type { Attempt } from "../../types";
import { Facts } from "../../ui";
import { clearedContext, cssVariable, inkLayer, masterInkLayer, useCanvasSide } from "../canvas";
import { centroid, compose, fitInSquare, interpolate, type Matrix, transformPoint } from "./alignment";
import { poseWords } from "./Verdict";

type InkLayers = { master: HTMLCanvasElement | null; copy: HTMLCanvasElement | null };

export function DistanceOverlay({ attempt, picture }: { attempt: Attempt; picture: string | null }) {
  const [share, setShare] = useState(1);
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const side = useCanvasSide(box);
  const [layers, setLayers] = useState<InkLayers>({ master: null, copy: null });
  const { align, residual, pose } = attempt.mark;
  const pivot = useMemo(() => centroid(residual?.copy ?? []), [residual]);
  useEffect(() => {
    let current = true;
    const take = (name: keyof InkLayers) => (layer: HTMLCanvasElement) => current && setLayers((old) => ({ ...old, [name]: layer }));
    masterInkLayer(attempt.work, cssVariable("rule")).then(take("master"), () => undefined);
    if (picture) inkLayer(picture, { ink: "dark", colour: cssVariable("soot") }).then(take("copy"), () => undefined);
    return () => {
      current = false;
    };
  }, [attempt.work.id, picture]);
  useEffect(() => {
    if (align && residual) draw(clearedContext(canvas.current, side), side, { attempt, layers, matrix: interpolate(align.matrix, share, pivot) });
  }, [side, share, layers, attempt]);
  if (!align || !residual) return <p class="note">{t("noOverlay")}</p>;
  return (
    <figure class="laid">
      <div ref={box} class="sheet">
        <canvas ref={canvas} role="img" aria-label={t("overlayAlt")} />
      </div>
      <figcaption>
        <label class="slider">
          <span>{t("asWritten")}</span>
          <input
            type="range" min="0" max="1" step="0.01" value={share} aria-label={t("alignLabel")}
            aria-valuetext={t("alignValue", { share: Math.round(100 * share) })}
            onInput={(event) => setShare(Number(event.currentTarget.value))}
          />
          <span>{t("aligned")}</span>
        </label>
        {pose && <p class="note"><Facts items={[t("poseShort", poseWords(pose)), t("colourNote")]} /></p>}
        <DistanceLegend />
      </figcaption>
    </figure>
  );
}

type Scene = { attempt: Attempt; layers: InkLayers; matrix: Matrix };

function draw(context: CanvasRenderingContext2D | null, side: number, { attempt, layers, matrix }: Scene): void {
  if (!context || !attempt.mark.residual) return;
  const frame = compose([side, 0, 0, side, 0, 0], fitInSquare(attempt.work.width, attempt.work.height));
  const copyToCanvas = compose(frame, matrix);
  const lay = (layer: HTMLCanvasElement | null, where: Matrix, opacity: number) => {
    if (!layer) return;
    context.setTransform(...(where as [number, number, number, number, number, number]));
    context.globalAlpha = opacity;
    context.drawImage(layer, 0, 0, 1, 1);
  };
  lay(layers.master, frame, 0.55);
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalAlpha = 1;
  context.drawImage(colouredInk(attempt.mark.residual.copy, layers.copy, copyToCanvas, side), 0, 0);
  context.strokeStyle = UNCOVERED;
  context.lineWidth = Math.max(1, side * 0.0024);
  for (const [x, y, r] of attempt.mark.residual.master) {
    if (r < UNCOVERED_FROM) continue;
    disc(context, transformPoint(frame, [x, y]), side * 0.0065);
    context.stroke();
  }
}

type Points = readonly (readonly [number, number, number])[];

/** The copy's ink in the colours of its distance: overlapping discs around the points, clipped to the ink. */
function colouredInk(points: Points, ink: HTMLCanvasElement | null, copyToCanvas: Matrix, side: number): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  const context = clearedContext(canvas, side)!;
  const reach = medianSpacing(points) * side * (ink ? 1.5 : 0.6);
  for (const [x, y, r] of [...points].sort((a, b) => a[2] - b[2])) {
    context.fillStyle = cssRgb(distanceColour(r));
    disc(context, transformPoint(copyToCanvas, [x, y]), reach);
    context.fill();
  }
  if (ink) {
    context.globalCompositeOperation = "destination-in";
    context.setTransform(...(copyToCanvas as [number, number, number, number, number, number]));
    context.drawImage(ink, 0, 0, 1, 1);
  }
  return canvas;
}

/** Median distance to the nearest neighbour, of a sample of the points. */
function medianSpacing(points: Points): number {
  const near = points.filter((_, k) => k % 7 === 0).map(([x, y]) =>
    points.reduce((least, [u, v]) => {
      const gap = Math.hypot(u - x, v - y);
      return gap > 1e-6 && gap < least ? gap : least;
    }, 1),
  );
  return near.sort((a, b) => a - b)[near.length >> 1] ?? 0.01;
}

function disc(context: CanvasRenderingContext2D, [x, y]: readonly [number, number], radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
}

function DistanceLegend() {
  return (
    <ul class="laid-key">
      <li>
        <span>{t("near")}</span>
        <svg viewBox="0 0 100 10" aria-hidden="true">
          {Array.from({ length: 12 }, (_, k) => (
            <circle key={k} cx={5 + 8.2 * k} cy="5" r={2.6 + (1.7 * k) / 11} fill={cssRgb(distanceColour(k / 11))} />
          ))}
        </svg>
        <span>{t("far")}</span>
      </li>
      <li>
        <svg class="ring" viewBox="0 0 10 10" aria-hidden="true">
          <circle cx="5" cy="5" r="3.6" fill="none" stroke={UNCOVERED} stroke-width="1.4" />
        </svg>
        <span>{t("uncovered")}</span>
      </li>
      <li>
        <svg class="ring" viewBox="0 0 10 10" aria-hidden="true">
          <rect class="laid-master" x="1" y="1" width="8" height="8" rx="1" />
        </svg>
        <span>{t("master")}</span>
      </li>
    </ul>
  );
}

type Rgb = readonly [number, number, number];

export const STOPS: readonly Rgb[] = [[168, 188, 196], [226, 196, 122], [222, 128, 56], [176, 34, 26]];
const UNCOVERED = "rgb(36 84 164)";
/** Distance from which a point of the master counts as left uncovered: 0.12 rms radii of the 0.3 that are r = 1. */
const UNCOVERED_FROM = 0.4;

export function distanceColour(r: number): Rgb {
  const at = Math.min(1, Math.max(0, r)) * (STOPS.length - 1);
  const k = Math.min(STOPS.length - 2, Math.floor(at));
  const mix = (i: 0 | 1 | 2) => Math.round(STOPS[k]![i] + (STOPS[k + 1]![i] - STOPS[k]![i]) * (at - k));
  return [mix(0), mix(1), mix(2)];
}

const cssRgb = ([r, g, b]: Rgb): string => `rgb(${r} ${g} ${b})`;
