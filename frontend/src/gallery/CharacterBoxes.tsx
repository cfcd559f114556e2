// The characters of a whole work over its picture: the one under the pointer is framed, a tap chooses one and shows its card.

import type { ComponentChildren } from "preact";
import { useEffect, useReducer, useRef } from "preact/hooks";
import type { CharacterWithin } from "../types";
import type { Viewer } from "../viewer/types";
import { characterAt, type Characters, middleOf } from "./wholeWork";

const MAX_TAP_DISTANCE = 6; // pixels of the screen
const MAX_TAP_MS = 500;

/** children: what is said of the one that is chosen. */
type Props = Characters & { viewer: Viewer; children: ComponentChildren };

export function CharacterBoxes({ viewer, characters, lit, chosen, shown, light, choose, children }: Props) {
  const [, redraw] = useReducer((n: number) => n + 1, 0);
  const acts = useRef({ light, choose });
  acts.current = { light, choose };
  useEffect(() => viewer.onDraw(() => redraw(undefined)), [viewer]);
  useEffect(() => listenForPointing(viewer, characters, acts), [viewer, characters]);
  const outline = (one: CharacterWithin) => pathOf(viewer, one.place.polygon);
  return (
    <div class="overlay">
      <svg width="100%" height="100%" aria-hidden="true">
        {shown && <path class="box all" d={characters.map(outline).join("")} />}
        {lit && lit !== chosen && <path class="box lit" d={outline(lit)} />}
        {chosen && <path class="box chosen" d={outline(chosen)} />}
      </svg>
      {chosen && <Card viewer={viewer} one={chosen} close={() => choose(null)}>{children}</Card>}
    </div>
  );
}

function pathOf(viewer: Viewer, polygon: [number, number][]): string {
  const points = polygon.map(([x, y]) => viewer.project(x, y));
  if (points.some((point) => point === null)) return "";
  return `M${points.map((point) => `${point!.x.toFixed(1)} ${point!.y.toFixed(1)}`).join("L")}Z`;
}

/** Beside the character, on the side where there is more room. */
function Card({ viewer, one, close, children }: { viewer: Viewer; one: CharacterWithin; close: () => void; children: ComponentChildren }) {
  const position = viewer.project(...middleOf(one.place.polygon));
  if (!position || !viewer.canvas) return null;
  const { clientWidth: wide, clientHeight: tall } = viewer.canvas;
  if (position.x < 0 || position.y < 0 || position.x > wide || position.y > tall) return null;
  const side = position.x > wide / 2 ? "left" : "right";
  const level = position.y > tall / 2 ? "above" : "below";
  return (
    <aside class={`pin-card ${side} ${level}`} style={{ left: `${position.x}px`, top: `${position.y}px` }}
      onPointerDown={(event) => event.stopPropagation()} onKeyDown={(event) => event.key === "Escape" && close()}>
      {children}
    </aside>
  );
}

type Acts = { current: Pick<Characters, "light" | "choose"> };

function listenForPointing(viewer: Viewer, characters: CharacterWithin[], acts: Acts): () => void {
  const host = viewer.canvas?.parentElement;
  if (!host) return () => undefined;
  const controller = new AbortController();
  const { signal } = controller;
  let start: { x: number; y: number; time: number } | null = null;
  const found = (event: PointerEvent) => {
    const box = host.getBoundingClientRect();
    const point = viewer.pick(event.clientX - box.left, event.clientY - box.top);
    return point && characterAt(characters, point);
  };
  host.addEventListener("pointermove", (event) => event.pointerType === "mouse" && !event.buttons && acts.current.light(found(event)), { signal, passive: true });
  host.addEventListener("pointerleave", () => acts.current.light(null), { signal });
  host.addEventListener("pointerdown", (event) => (start = event.isPrimary && event.button === 0 ? { x: event.clientX, y: event.clientY, time: event.timeStamp } : null), { signal });
  host.addEventListener("pointerup", (event) => {
    const tapped = start && Math.hypot(event.clientX - start.x, event.clientY - start.y) < MAX_TAP_DISTANCE && event.timeStamp - start.time < MAX_TAP_MS;
    start = null;
    if (tapped && (viewer.tool === "light" || viewer.tool === "move")) acts.current.choose(found(event));
  }, { signal });
  return () => controller.abort();
}
