import { useState } from "preact/hooks";
import { WorkFacts } from "../src/gallery/WorkFacts";
import { common, language, localize } from "../src/i18n";
import type { ViewerFacts, Work } from "../src/types";
import { ViewerPanel } from "../src/viewer/ViewerPanel";
import { stateFromQuery } from "../src/viewer/state";
import type { Viewer } from "../src/viewer/types";
import "../src/gallery/work.css";
import "./page.css";

/** The data that `rumu gallery export --html` writes into the page; every URL is a data: URL. */
export type PageFacts = { work: Omit<Work, "files" | "thumb" | "thumb_normals" | "previous" | "next">; viewer: ViewerFacts };

export function OnePage({ facts, onViewer }: { facts: PageFacts; onViewer: (viewer: Viewer | null) => void }) {
  const [initial] = useState(() => stateFromQuery(new URLSearchParams(location.hash.split("?")[1] ?? "")));
  const [chosen, choose] = useState<string | null>(null);
  const { work, viewer } = facts;
  return (
    <main>
      <button type="button" class="quiet one-language" lang={language.value === "zh" ? "en" : "zh-Hant"}
        onClick={() => (language.value = language.value === "zh" ? "en" : "zh")}>
        {common("language")}
      </button>
      <article class="work">
        <div class="work-stage">
          <ViewerPanel surface={{ facts: viewer, title: work.title }} initial={initial} pins={{ items: work.annotations, chosen, choose }} onViewer={onViewer} />
        </div>
        <aside class="label">
          <WorkFacts work={work} facts={viewer} alone />
          {work.annotations.map((note) => (
            <section key={note.id}><h2>{localize(note.title)}</h2><p>{localize(note.text)}</p></section>
          ))}
        </aside>
      </article>
    </main>
  );
}
