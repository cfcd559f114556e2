// A work that no surface can be made of: its picture, which can be moved and looked at from near, without a lamp.

import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { localize } from "../i18n";
import { t } from "../i18n/viewer";
import type { ViewerFacts, Work } from "../types";
import { ErrorMessage } from "../ui";
import { Icon } from "../viewer/Icon";
import type { Viewer } from "../viewer/types";
import { createViewer } from "../viewer/viewer";

/** Longest side, in pixels, of works that have no tiles. */
const WITHOUT_TILES = 1024;
/** One height, 0, and one normal, straight up. */
const NO_HEIGHT = { url: "data:application/octet-stream;base64,AAAAAA==", width: 1, height: 1, min: 0, max: 0 };
const UP = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNoaPgPAAODAgAApfuJAAAAAElFTkSuQmCC";

/** What the viewer needs to show a picture as it is. */
export function flatFacts(work: Work): ViewerFacts {
  const { picture } = work.files;
  const large = Math.max(work.width, work.height) > WITHOUT_TILES;
  return {
    ...{ width: work.width, height: work.height, unit: "px", spacing: 1, source: "inflation", source_text: { zh: "", en: "" } },
    ...{ heights: NO_HEIGHT, normals: UP, albedo: picture, picture, mask: picture, three_lamps: null, glb: "" },
    tiles: large ? { albedo: `iiif/tiles/albedo/${encodeURIComponent(work.id)}`, normals: null, version: "" } : null,
  };
}

export function FlatView({ work, children }: { work: Work; children?: (viewer: Viewer) => ComponentChildren }) {
  const host = useRef<HTMLDivElement>(null);
  const [viewer, setViewer] = useState<Viewer | null>(null);
  const [error, setError] = useState<unknown>(null);
  useEffect(() => {
    const controller = new AbortController();
    let created: Viewer | null = null;
    createViewer(host.current!, flatFacts(work), { slant: 0, look: "exact", signal: controller.signal }).then(
      (ready) => {
        if (controller.signal.aborted) return ready.dispose();
        created = ready;
        ready.tool = "move";
        setViewer(ready);
      },
      (problem: unknown) => !controller.signal.aborted && setError(problem),
    );
    return () => {
      controller.abort();
      created?.dispose();
    };
  }, [work.files.picture]);
  return (
    <div class="flat-work viewer-stage">
      <div class="viewer-host" ref={host} role="application" aria-label={localize(work.title)} />
      {viewer ? children?.(viewer) : error ? <ErrorMessage error={error} /> : null}
      {viewer?.canvas && <button type="button" class="tool flat-all" title={t("reset")} aria-label={t("reset")} onClick={() => viewer.set({ camera: null })}><Icon name="home" /></button>}
    </div>
  );
}
