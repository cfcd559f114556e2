import { useEffect, useRef, useState } from "preact/hooks";
import { common, localize } from "../i18n";
import { t } from "../i18n/gallery";
import { t as ofWhole } from "../i18n/whole";
import type { WorkCard } from "../types";
import { Facts } from "../ui";
import { lightAt } from "../viewer/state";
import { type CardImage, loadCardImage, paintRelit } from "./relighting";
import { scriptName } from "./labels";
import { dynasties } from "./listState";

const TURN_MS = 1400;

export function GalleryCard({ work }: { work: WorkCard & { characters?: number } }) {
  const dynasty = dynasties.value.get(work.dynasty);
  const about = [scriptName(work.script), localize(work.hand), dynasty ? localize(dynasty) : localize(work.period) || work.dynasty].filter((fact) => fact.trim());
  return (
    <li class="card">
      <a href={`#/works/${encodeURIComponent(work.id)}`}>
        <RelitThumb work={work} />
        <span class="card-title">{localize(work.title)}</span>
        <span class="card-about"><Facts items={about.slice(0, 2)} /></span>
        {about.length > 2 && <span class="card-about"><Facts items={about.slice(2)} /></span>}
        {work.characters ? <span class="card-about">{ofWhole("characters", { n: work.characters.toLocaleString() })}</span> : null}
        <HeightMark work={work} />
      </a>
    </li>
  );
}

/** Whether the height was measured or computed; the whole sentence on hover and for screen readers. */
function HeightMark({ work }: { work: WorkCard }) {
  const measured = work.height_source === "photometric";
  return (
    <span class={measured ? "card-height measured" : "card-height"} title={common(work.height_source)}>
      {t(measured ? "measured" : "computed")}
      <span class="visually-hidden">{common(work.height_source)}</span>
    </span>
  );
}

export function RelitThumb({ work }: { work: Pick<WorkCard, "thumb" | "thumb_normals" | "height_source"> }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const cardImage = useRef<Promise<CardImage> | null>(null);
  const frame = useRef(0);
  const box = useRef<HTMLSpanElement>(null);
  const [lit, setLit] = useState(false);
  const show = (tilt: number, slant: number) => {
    cancelAnimationFrame(frame.current);
    frame.current = requestAnimationFrame(async () => {
      cardImage.current ??= loadCardImage(work.thumb, work.thumb_normals);
      const card = await cardImage.current.catch(() => null);
      if (!card || !canvas.current) return;
      paintRelit(canvas.current, card, tilt, slant, work.height_source === "photometric");
      setLit(true);
    });
  };
  const follow = (event: PointerEvent) => {
    if (event.pointerType === "touch") return;
    const frame = box.current!.getBoundingClientRect();
    const { tilt, slant } = lightAt(event.clientX - frame.left, event.clientY - frame.top, frame);
    show(tilt, Math.min(slant, 72));
  };
  const leave = () => {
    cancelAnimationFrame(frame.current);
    setLit(false);
  };
  useEffect(() => {
    // Without a pointer, as when the keyboard selects the card, the lamp circles once.
    const link = box.current?.closest("a");
    const walk = () => {
      if (!link?.matches(":focus-visible")) return;
      const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
      const start = performance.now();
      const step = (now: number) => {
        const part = Math.min(1, (now - start) / TURN_MS);
        show(135 - (still ? 0 : part * 360), 55);
        if (!still && part < 1 && document.activeElement === link) setTimeout(() => requestAnimationFrame(step), 30);
      };
      step(start);
    };
    link?.addEventListener("focus", walk);
    link?.addEventListener("blur", leave);
    return () => {
      cancelAnimationFrame(frame.current);
      link?.removeEventListener("focus", walk);
      link?.removeEventListener("blur", leave);
    };
  }, []);
  return (
    <span class="thumb" ref={box} onPointerMove={follow} onPointerLeave={leave}>
      <img src={work.thumb} alt="" loading="lazy" decoding="async" width="256" height="256" />
      <canvas ref={canvas} class={lit ? "lit" : ""} aria-hidden="true" />
    </span>
  );
}
