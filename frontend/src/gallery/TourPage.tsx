import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { get, session } from "../api";
import { say, words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import { rewrite, type PageProps } from "../router";
import type { Tour, TourStep } from "../types";
import { PageTrouble, Trouble, useLoaded, Waiting } from "../ui";
import { Icon } from "../viewer/icons";
import { ViewerPanel } from "../viewer/panel";
import { START, stateFromQuery, stateToQuery, type ViewState } from "../viewer/state";
import type { Viewer } from "../viewer/types";
import { licenceName } from "./scripts";
import { unnumbered } from "./titles";
import { TourEditor } from "./TourEditor";
import { loadWork } from "./WorkPage";
import "./gallery.css";
import "./work.css";

const t = words(table);
const GLIDE = 1600;

export default function TourPage({ params, query }: PageProps) {
  const id = params.id ?? "";
  const found = useLoaded((signal) => get<Tour>(`/api/tours/${encodeURIComponent(id)}`, signal), id);
  if (found.error) return <PageTrouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  return <Walk key={id} given={found.value} query={query} />;
}

const viewOf = (step: TourStep): ViewState => stateFromQuery(new URLSearchParams(step.view));

function Walk({ given, query }: { given: Tour; query: URLSearchParams }) {
  const [tour, setTour] = useState(given);
  const [at, setAt] = useState(Math.min(Math.max(Number(query.get("step") ?? 1) - 1, 0), Math.max(given.steps.length - 1, 0)));
  const [editing, setEditing] = useState(query.get("edit") === "1");
  const viewer = useRef<Viewer | null>(null);
  const now = useRef<ViewState>(START);
  const step = tour.steps[at];
  const owner = session.value?.person?.role === "owner";
  const move = (to: number) => {
    setAt(to);
    const kept = new URLSearchParams(to ? { step: String(to + 1) } : {});
    if (editing) kept.set("edit", "1");
    rewrite(kept);
  };
  useEffect(() => {
    if (step && viewer.current) viewer.current.glide(viewOf(step), GLIDE);
  }, [at]);
  const met = (found: Viewer | null) => {
    viewer.current = found;
    if (found && step) {
      now.current = found.state;
      found.glide(viewOf(step), GLIDE);
    }
  };
  return (
    <article class={editing ? "work tour editing" : "work tour"}>
      <div class="work-stage">
        {step ? <StepStage key={step.work} step={step} met={met} heard={(state) => (now.current = state)} /> : <p class="nothing">{t("tourEmpty")}</p>}
      </div>
      <aside class="label">
        <h1>{say(tour.title)}</h1>
        {owner && (
          <button type="button" class="quiet" onClick={() => setEditing(!editing)}>
            <Icon name={editing ? "play" : "edit"} />{t(editing ? "doneEditing" : "editTour")}
          </button>
        )}
        {editing ? (
          <TourEditor tour={tour} at={at} onMove={move} onChange={setTour} view={() => stateToQuery(now.current).toString()} />
        ) : (
          step && <Telling tour={tour} at={at} step={step} move={move} />
        )}
      </aside>
    </article>
  );
}

function StepStage({ step, met, heard }: { step: TourStep; met: (viewer: Viewer | null) => void; heard: (state: ViewState) => void }) {
  const loaded = useLoaded((signal) => loadWork(step.work, signal), step.work);
  const shown = useMemo(() => loaded.value && { facts: loaded.value.facts, title: loaded.value.work.title }, [loaded.value]);
  const [initial] = useState<ViewState>(() => ({ ...START, mode: viewOf(step).mode }));
  if (loaded.error) return <Trouble error={loaded.error} again={loaded.again} />;
  if (!shown || !loaded.value) return <Waiting />;
  const { work } = loaded.value;
  return (
    <>
      <ViewerPanel shown={shown} initial={initial} onViewer={met} onState={heard} />
      <p class="note">
        <a href={`#/works/${encodeURIComponent(work.id)}`}>{say(work.title)}</a> · {say(work.hand)} · {licenceName(work.licence)} · {say(shown.facts.source_text)}
      </p>
    </>
  );
}

function Telling({ tour, at, step, move }: { tour: Tour; at: number; step: TourStep; move: (to: number) => void }) {
  const last = at === tour.steps.length - 1;
  return (
    <section class="telling" aria-live="polite">
      <p class="note">{t("step", { k: at + 1, n: tour.steps.length })}</p>
      <h2>{unnumbered(say(step.title))}</h2>
      <p class="told">{say(step.text)}</p>
      <div class="walk">
        <button type="button" class="quiet" disabled={at === 0} onClick={() => move(at - 1)}><Icon name="previous" />{t("back")}</button>
        {last ? <a class="button" href="#/tours">{t("finish")}</a> : <button type="button" onClick={() => move(at + 1)}>{t("onward")}<Icon name="next" /></button>}
      </div>
      <ol class="dots">
        {tour.steps.map((s, k) => (
          <li key={k}><button type="button" aria-current={k === at ? "step" : undefined} aria-label={`${k + 1}. ${unnumbered(say(s.title))}`} onClick={() => move(k)} /></li>
        ))}
      </ol>
    </section>
  );
}
