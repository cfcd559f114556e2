// Copy and master laid on each other: the copy's ink coloured by how far it strays, and a slider from the copy as it
// was written to the copy as it was laid on the master to be marked.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Attempt } from "../../types";
import { cleared, token, useSide } from "../canvas";
import { inkLayer } from "../ink/inklayer";
import { w } from "../say";
import { masterInk } from "../WritingCell";
import { after, between, contained, middle, moved, type Matrix } from "./align";
import { colourOf, css, UNCOVERED, UNCOVERED_FROM } from "./colours";
import { poseWords } from "./Verdict";

type Layers = { master: HTMLCanvasElement | null; copy: HTMLCanvasElement | null };

export function Overlay({ attempt, picture }: { attempt: Attempt; picture: string | null }) {
  const [share, setShare] = useState(1);
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const side = useSide(box);
  const [layers, setLayers] = useState<Layers>({ master: null, copy: null });
  const { align, residual, pose } = attempt.mark;
  const pivot = useMemo(() => middle(residual?.copy ?? []), [residual]);
  useEffect(() => {
    let current = true;
    const take = (name: keyof Layers) => (layer: HTMLCanvasElement) => current && setLayers((old) => ({ ...old, [name]: layer }));
    masterInk(attempt.work, token("rule")).then(take("master"), () => undefined);
    if (picture) inkLayer(picture, { ink: "dark", colour: token("soot") }).then(take("copy"), () => undefined);
    return () => {
      current = false;
    };
  }, [attempt.work.id, picture]);
  useEffect(() => {
    if (align && residual) draw(cleared(canvas.current, side), side, { attempt, layers, matrix: between(align.matrix, share, pivot) });
  }, [side, share, layers, attempt]);
  if (!align || !residual) return <p class="note">{w("noOverlay")}</p>;
  return (
    <figure class="laid">
      <div ref={box} class="sheet">
        <canvas ref={canvas} role="img" aria-label={w("overlayAlt")} />
      </div>
      <figcaption>
        <label class="slider">
          <span>{w("asWritten")}</span>
          <input
            type="range" min="0" max="1" step="0.01" value={share} aria-label={w("alignLabel")}
            aria-valuetext={w("alignValue", { share: Math.round(100 * share) })}
            onInput={(event) => setShare(Number(event.currentTarget.value))}
          />
          <span>{w("aligned")}</span>
        </label>
        {pose && <p class="note">{w("poseShort", poseWords(pose))} · {w("colourNote")}</p>}
        <Legend />
      </figcaption>
    </figure>
  );
}

type Scene = { attempt: Attempt; layers: Layers; matrix: Matrix };

function draw(context: CanvasRenderingContext2D | null, side: number, { attempt, layers, matrix }: Scene): void {
  if (!context || !attempt.mark.residual) return;
  const frame = after([side, 0, 0, side, 0, 0], contained(attempt.work.width, attempt.work.height));
  const place = after(frame, matrix);
  const lay = (layer: HTMLCanvasElement | null, where: Matrix, opacity: number) => {
    if (!layer) return;
    context.setTransform(...(where as [number, number, number, number, number, number]));
    context.globalAlpha = opacity;
    context.drawImage(layer, 0, 0, 1, 1);
  };
  lay(layers.master, frame, 0.55);
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalAlpha = 1;
  context.drawImage(strays(attempt.mark.residual.copy, layers.copy, place, side), 0, 0);
  context.strokeStyle = UNCOVERED;
  context.lineWidth = Math.max(1, side * 0.0024);
  for (const [x, y, r] of attempt.mark.residual.master) {
    if (r < UNCOVERED_FROM) continue;
    disc(context, moved(frame, [x, y]), side * 0.0065);
    context.stroke();
  }
}

type Points = readonly (readonly [number, number, number])[];

/** The copy's ink in the colours of its distance: a disc a point, wide enough to meet its neighbours, cut to the ink. */
function strays(points: Points, ink: HTMLCanvasElement | null, place: Matrix, side: number): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  const context = cleared(canvas, side)!;
  const reach = pitch(points) * side * (ink ? 1.5 : 0.6);
  for (const [x, y, r] of [...points].sort((a, b) => a[2] - b[2])) {
    context.fillStyle = css(colourOf(r));
    disc(context, moved(place, [x, y]), reach);
    context.fill();
  }
  if (ink) {
    context.globalCompositeOperation = "destination-in";
    context.setTransform(...(place as [number, number, number, number, number, number]));
    context.drawImage(ink, 0, 0, 1, 1);
  }
  return canvas;
}

/** Median distance to the nearest neighbour, of some points. */
function pitch(points: Points): number {
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

function Legend() {
  return (
    <ul class="laid-key">
      <li>
        <span>{w("near")}</span>
        <svg viewBox="0 0 100 10" aria-hidden="true">
          {Array.from({ length: 12 }, (_, k) => (
            <circle key={k} cx={5 + 8.2 * k} cy="5" r={2.6 + (1.7 * k) / 11} fill={css(colourOf(k / 11))} />
          ))}
        </svg>
        <span>{w("far")}</span>
      </li>
      <li>
        <svg class="ring" viewBox="0 0 10 10" aria-hidden="true">
          <circle cx="5" cy="5" r="3.6" fill="none" stroke={UNCOVERED} stroke-width="1.4" />
        </svg>
        <span>{w("uncovered")}</span>
      </li>
      <li>
        <svg class="ring" viewBox="0 0 10 10" aria-hidden="true">
          <rect class="laid-master" x="1" y="1" width="8" height="8" rx="1" />
        </svg>
        <span>{w("master")}</span>
      </li>
    </ul>
  );
}

