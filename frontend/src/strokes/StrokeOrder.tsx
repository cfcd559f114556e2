// The strokes of a character, written one after another as copybooks teach them.

import { useEffect, useId, useState } from "preact/hooks";
import { get } from "../api";
import { localize } from "../i18n";
import { useSize } from "../ui";
import { t } from "../i18n/strokes";
import type { CharacterStrokes, WorkCard } from "../types";
import { Icon } from "../viewer/Icon";
import { placeNumbers } from "./numbers";
import "./strokes.css";

const SPEED = 1.1; // sides of the square in a second
const PAUSE = 0.25; // seconds between strokes
const BRUSH = 0.17; // width of the line that fills an outline, in sides of the square
const NUMBER = 10; // radius of a number in pixels
const UNSEEN = 240; // pixels, until the square is measured

/** Whether an order of strokes is shown beside a work: in other scripts characters are not written as copybooks of today teach. */
export const hasStrokeOrder = (work: Pick<WorkCard, "script" | "character">): boolean =>
  (work.script === "regular" || work.script === "running") && [...work.character].length === 1;

const lengthOf = (line: readonly [number, number][]): number =>
  line.slice(1).reduce((sum, [x, y], k) => sum + Math.hypot(x - line[k]![0], y - line[k]![1]), 0);

/** How many strokes are written after so many seconds, and which share of the next one. */
export function writtenAfter(seconds: number, lengths: readonly number[]): { count: number; share: number } {
  let left = seconds;
  for (const [count, length] of lengths.entries()) {
    const time = length / SPEED;
    if (left < time) return { count, share: left / time };
    left -= time + PAUSE;
    if (left < 0) return { count: count + 1, share: 0 };
  }
  return { count: lengths.length, share: 0 };
}

/** Nothing for a character whose strokes are not known. */
export function StrokeOrder({ character }: { character: string }) {
  const [known, setKnown] = useState<CharacterStrokes | null>(null);
  useEffect(() => {
    const ended = new AbortController();
    if ([...character].length === 1)
      get<CharacterStrokes>(`api/characters/${encodeURIComponent(character)}`, ended.signal).then(setKnown, () => setKnown(null));
    return () => ended.abort();
  }, [character]);
  return known && <Strokes character={known} />;
}

function Strokes({ character: { character, strokes } }: { character: CharacterStrokes }) {
  const id = useId();
  const [count, setCount] = useState(strokes.length); // written in full
  const [share, setShare] = useState(0); // of the next one
  const [playing, setPlaying] = useState(false);
  const [numbered, setNumbered] = useState(false);
  const [square, { width: side }] = useSize();
  useEffect(() => {
    if (!playing) return;
    const lengths = strokes.map((stroke) => lengthOf(stroke.centre_line));
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const began = performance.now();
    let frame = requestAnimationFrame(function step(now) {
      const written = writtenAfter((now - began) / 1000, lengths);
      setCount(written.count);
      setShare(still ? 0 : written.share);
      if (written.count < strokes.length) frame = requestAnimationFrame(step);
      else setPlaying(false);
    });
    return () => cancelAnimationFrame(frame);
  }, [playing, strokes]);
  const show = (n: number) => (setPlaying(false), setShare(0), setCount(Math.min(Math.max(n, 0), strokes.length)));
  const back = () => show(share > 0 ? count : count - 1);
  const play = () => (playing ? show(count) : setPlaying(true));
  const step = (event: KeyboardEvent) => {
    const take = { ArrowLeft: back, ArrowRight: () => show(count + 1) }[event.key];
    if (take) (event.preventDefault(), take());
  };
  const next = strokes[count];
  const now = share > 0 ? count : count - 1;
  const name = strokes[now] && t("strokeNow", { k: now + 1, name: localize(strokes[now]!.name) });
  return (
    <section class="stroke-order" onKeyDown={step}>
      <h2>{t("strokeOrder")}</h2>
      <svg viewBox="0 0 1 1" role="img" aria-label={`${t("strokeOrder")}: ${character}`} ref={square} onClick={play}>
        <path class="cross" d="M 0 .5 H 1 M .5 0 V 1 M 0 0 L 1 1 M 1 0 L 0 1" />
        {strokes.map((stroke, k) => <path key={k} class={k < count ? (k === now && (playing || count < strokes.length) ? "now" : "written") : "to-come"} d={stroke.path} />)}
        {next && share > 0 && (
          <>
            <clipPath id={id}><path d={next.path} /></clipPath>
            <polyline class="brush" clip-path={`url(#${id})`} points={next.centre_line.map((p) => p.join(",")).join(" ")}
              stroke-width={BRUSH} pathLength={1} stroke-dasharray="1 2" stroke-dashoffset={1 - share} />
          </>
        )}
        {numbered && <Numbers lines={strokes.map((stroke) => stroke.centre_line)} radius={NUMBER / (side || UNSEEN)} />}
      </svg>
      <p class="stroke-name" aria-live={playing ? "off" : "polite"}>{name || "\u00a0"}</p>
      <div class="stroke-buttons">
        <button type="button" class="quiet" aria-label={t("strokeBack")} title={t("strokeBack")} disabled={count === 0} onClick={back}><Icon name="previous" /></button>
        <button type="button" onClick={play}>{t(playing ? "stopStrokes" : "playStrokes")}</button>
        <button type="button" class="quiet" aria-label={t("strokeOn")} title={t("strokeOn")} disabled={count === strokes.length} onClick={() => show(count + 1)}><Icon name="next" /></button>
        <label><input type="checkbox" checked={numbered} onChange={(event) => setNumbered(event.currentTarget.checked)} />{t("strokeNumbers")}</label>
      </div>
      <p class="note">{strokes.length === 1 ? t("strokeOrderNoteOne") : t("strokeOrderNote", { n: strokes.length })}</p>
    </section>
  );
}

function Numbers({ lines, radius }: { lines: [number, number][][]; radius: number }) {
  const places = placeNumbers(lines.map((line) => ({ lines: [line] })), { width: 1, height: 1, radius, from: "start" });
  return (
    <>
      {places.map(({ x, y, tether }, k) => (
        <g key={k} class="stroke-number">
          {tether && <path d={`M${tether[0]} ${tether[1]}L${x} ${y}`} />}
          <circle cx={x} cy={y} r={radius} />
          <text x={x} y={y} font-size={1.3 * radius}>{k + 1}</text>
        </g>
      ))}
    </>
  );
}
