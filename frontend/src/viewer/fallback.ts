// Where WebGL2 is missing: the picture, a sentence, and a viewer that does nothing else.

import { effect } from "@preact/signals";
import { t } from "../i18n/viewer";
import type { ViewerFacts } from "../types";
import { DEFAULT_VIEW } from "./state";
import type { Viewer } from "./types";

let known: boolean | null = null;

/** Asked once: each context that is tried counts against the browser's few. */
export function hasWebGL2(): boolean {
  if (known !== null) return known;
  const context = typeof WebGL2RenderingContext === "undefined" ? null : document.createElement("canvas").getContext("webgl2");
  known = context !== null;
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return known;
}

export function createPictureViewer(host: HTMLElement, facts: ViewerFacts): Viewer {
  const box = document.createElement("figure");
  box.className = "viewer-picture";
  const image = document.createElement("img");
  image.src = facts.picture;
  const note = document.createElement("figcaption");
  const forget = effect(() => {
    image.alt = t("picture");
    note.textContent = t("noWebgl");
  });
  box.append(image, note);
  host.append(box);
  const whole = async (): Promise<Blob> => (await fetch(facts.picture)).blob();
  return {
    facts,
    state: DEFAULT_VIEW,
    field: null,
    canvas: null,
    interval: 1,
    tool: "light",
    set: () => undefined,
    animateTo: () => undefined,
    link: () => undefined,
    snapshot: whole,
    relit: whole,
    resize: () => undefined,
    dispose: () => {
      forget();
      box.remove();
    },
    pick: () => null,
    section: () => [],
    project: () => null,
    onDraw: () => () => undefined,
    immerse: () => Promise.reject(new Error("WebGL2 is missing")),
  };
}
