// Replays the strokes of an attempt at the speed at which they were written.

import { useEffect, useRef, useState } from "preact/hooks";
import { get } from "../api";
import { t } from "../i18n/studio";
import type { Attempt } from "../types";
import { clearedContext, cssVariable, useCanvasSide } from "./canvas";
import { paintStrokes } from "./ink/painting";
import { parseStrokes, type Stroke } from "./ink/strokes";
import { GridLines } from "./grids";

const PAUSE = 250; // ms between strokes; the real pauses are not recorded

/** What had been written after so many ms. */
export function strokesUntil(strokes: readonly Stroke[], ms: number): Stroke[] {
  const written: Stroke[] = [];
  let start = 0;
  for (const stroke of strokes) {
    if (start > ms) break;
    written.push({ ...stroke, points: stroke.points.filter((point) => start + point[2] <= ms) });
    start += (stroke.points.at(-1)?.[2] ?? 0) + PAUSE;
  }
  return written.filter((stroke) => stroke.points.length > 0);
}

export const replayDuration = (strokes: readonly Stroke[]): number =>
  strokes.reduce((sum, stroke) => sum + (stroke.points.at(-1)?.[2] ?? 0) + PAUSE, 0);

export function Replay({ attempt }: { attempt: Attempt }) {
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const side = useCanvasSide(box);
  const [strokes, setStrokes] = useState<Stroke[] | null>(null);
  const [at, setAt] = useState(0);
  const [running, setRunning] = useState(false);
  const whole = strokes ? replayDuration(strokes) : 0;
  useEffect(() => {
    get(`api/attempts/${attempt.id}/strokes`).then((saved) => {
      const parsed = parseStrokes(saved);
      setStrokes(parsed);
      setAt(replayDuration(parsed));
    }, () => setStrokes([]));
  }, [attempt.id]);
  useEffect(() => {
    const context = clearedContext(canvas.current, side);
    if (!context || !strokes) return;
    context.fillStyle = cssVariable("soot");
    paintStrokes(context, strokesUntil(strokes, at), side);
  }, [side, strokes, at]);
  useEffect(() => {
    if (!running) return;
    const began = performance.now() - at;
    let frame = requestAnimationFrame(function step(now) {
      setAt(Math.min(whole, now - began));
      if (now - began < whole) frame = requestAnimationFrame(step);
      else setRunning(false);
    });
    return () => cancelAnimationFrame(frame);
  }, [running]);
  if (strokes && !strokes.length) return null;
  return (
    <section class="panel replay">
      <h2>{t("replay")}</h2>
      <div ref={box} class="sheet">
        <GridLines grid={attempt.grid} />
        <canvas ref={canvas} role="img" aria-label={t("replayAlt", { count: strokes?.length ?? 0 })} />
      </div>
      <label class="slider">
        <button type="button" class="quiet" onClick={() => (at >= whole && setAt(0), setRunning(!running))}>
          {running ? t("pause") : t("play")}
        </button>
        <input
          type="range" min="0" max={whole} value={at} aria-label={t("replay")} aria-valuetext={`${(at / 1000).toFixed(1)} s`}
          onInput={(event) => (setRunning(false), setAt(Number(event.currentTarget.value)))}
        />
      </label>
    </section>
  );
}
