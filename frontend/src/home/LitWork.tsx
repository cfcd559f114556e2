// A work under a lamp that circles once and follows the pointer, the finger or the tilt of a phone.

import { useEffect, useRef, useState } from "preact/hooks";
import { common, localize } from "../i18n";
import { t } from "../i18n/home";
import type { CoverWork } from "../types";
import { circling, hasCircled, type Lamp, pointed, tilted } from "./lampMotion";
import { createLampPicture } from "./lampPicture";
import "./home.css";

type Draw = typeof createLampPicture;

export function LitWork({ work, draw = createLampPicture }: { work: CoverWork; draw?: Draw }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [move, setMove] = useState<((lamp: Lamp) => void) | null>(null);
  const [shown, setShown] = useState<"waiting" | "lit" | "flat">("waiting");
  const touch = matchMedia("(pointer: coarse)").matches;
  useEffect(() => {
    const controller = new AbortController();
    const files = { picture: work.picture, normals: work.normals, measured: work.height_source === "photometric" };
    const picture = draw(canvas.current!, files, controller.signal);
    void picture.then(({ light, dispose }) => {
      if (controller.signal.aborted) return dispose();
      const stop = startCircling((lamp) => light(lamp.tilt, lamp.slant));
      controller.signal.addEventListener("abort", () => (stop(), dispose()));
      setMove(() => (lamp: Lamp) => (stop(), requestAnimationFrame(() => light(lamp.tilt, lamp.slant))));
      setShown("lit");
    }, () => controller.signal.aborted || setShown("flat")); // the plain picture stays, as of a leaf without writing
    return () => (controller.abort(), setShown("waiting"));
  }, [work.id]);
  const follow = (event: PointerEvent) => {
    const frame = canvas.current!.getBoundingClientRect();
    move?.(pointed(event.clientX - frame.left, event.clientY - frame.top, frame));
  };
  return (
    <figure class="lit-work">
      <a href={`#/works/${encodeURIComponent(work.id)}`} aria-label={t("seeWork", { title: localize(work.title) })} onPointerMove={follow}
        style={{ aspectRatio: `${work.width} / ${work.height}`, "--shape": work.width / work.height }}>
        <img src={work.picture} alt="" width={work.width} height={work.height} fetchpriority="high"
          onError={(event) => event.currentTarget.src.endsWith(work.thumb) || (event.currentTarget.src = work.thumb)} />
        <canvas ref={canvas} class={shown === "lit" ? "lit" : ""} aria-hidden="true" />
      </a>
      <figcaption>
        <strong>{localize(work.title)}</strong> {localize(work.hand)}
        {shown !== "flat" && <small>{common(work.height_source)}</small>}
        {shown !== "flat" && <small>{t(touch ? "lampHintTouch" : "lampHint")}</small>}
        {touch && move && <TiltButton move={move} />}
      </figcaption>
    </figure>
  );
}

/** Lets the lamp circle once, unless the reader wants no motion; returns what stops it. */
function startCircling(light: (lamp: Lamp) => void): () => void {
  light(circling(0));
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) return () => undefined;
  const start = performance.now();
  let frame = 0;
  const step = (now: number) => {
    const seconds = (now - start) / 1000;
    light(circling(hasCircled(seconds) ? 0 : seconds));
    if (!hasCircled(seconds)) frame = requestAnimationFrame(step);
  };
  frame = requestAnimationFrame(step);
  return () => cancelAnimationFrame(frame);
}

type Orientation = { requestPermission?: () => Promise<string> };

/** Asks for the phone's tilt, which some browsers give only after a tap, and moves the lamp with it. */
function TiltButton({ move }: { move: (lamp: Lamp) => void }) {
  const [state, setState] = useState<"" | "on" | "refused">("");
  const kind = (globalThis as { DeviceOrientationEvent?: Orientation }).DeviceOrientationEvent;
  useEffect(() => {
    if (state !== "on") return;
    const listen = ({ beta, gamma }: DeviceOrientationEvent) => beta !== null && gamma !== null && move(tilted(beta, gamma));
    addEventListener("deviceorientation", listen);
    return () => removeEventListener("deviceorientation", listen);
  }, [state]);
  if (!kind || state === "on") return null;
  const ask = async () => {
    const answer = await (kind.requestPermission?.() ?? Promise.resolve("granted")).catch(() => "denied");
    setState(answer === "granted" ? "on" : "refused");
  };
  return state === "refused" ? <small role="status">{t("noTilt")}</small> : <button type="button" class="quiet small" onClick={() => void ask()}>{t("useTilt")}</button>;
}
