// Without WebGL2: the picture, a message, and a Viewer whose methods do nothing.

import { effect } from "@preact/signals";
import { t } from "../i18n/viewer";
import type { ViewerFacts } from "../types";
import { DEFAULT_VIEW } from "./state";
import type { Viewer } from "./types";

let supported: boolean | null = null;

/** Tested once, since a browser allows only a few contexts. */
export function hasWebGL2(): boolean {
  if (supported !== null) return supported;
  const context = typeof WebGL2RenderingContext === "undefined" ? null : document.createElement("canvas").getContext("webgl2");
  supported = context !== null;
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return supported;
}

export function createPictureViewer(host: HTMLElement, facts: ViewerFacts): Viewer {
  const box = document.createElement("figure");
  box.className = "viewer-picture";
  const image = document.createElement("img");
  image.src = facts.picture;
  const note = document.createElement("figcaption");
  const stopTranslating = effect(() => {
    image.alt = t("picture");
    note.textContent = t("noWebgl");
  });
  box.append(image, note);
  host.append(box);
  const fetchPicture = async (): Promise<Blob> => (await fetch(facts.picture)).blob();
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
    snapshot: fetchPicture,
    relit: fetchPicture,
    resize: () => undefined,
    dispose: () => {
      stopTranslating();
      box.remove();
    },
    pick: () => null,
    section: () => [],
    project: () => null,
    onDraw: () => () => undefined,
    immerse: () => Promise.reject(new Error("WebGL2 is missing")),
  };
}
