import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { get, session } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import { kiosk } from "../kiosk";
import { type PageProps, replaceQuery } from "../router";
import type { Tour, TourStep } from "../types";
import { ErrorMessage, ErrorPage, Facts, Loading, useLoaded } from "../ui";
import { Icon } from "../viewer/Icon";
import { ViewerPanel } from "../viewer/ViewerPanel";
import { DEFAULT_VIEW, stateFromQuery, stateToQuery, type ViewState } from "../viewer/state";
import type { Viewer } from "../viewer/types";
import { withoutNumber } from "./labels";
import { Licence } from "./licences";
import { TourEditor } from "./TourEditor";
import { loadWork } from "./WorkPage";
import "./gallery.css";
import "./work.css";

const ANIMATION_MS = 1600;
const PLAY_MS = 14_000;

export default function TourPage({ params, query }: PageProps) {
  const id = params.id ?? "";
  const loaded = useLoaded((signal) => get<Tour>(`api/tours/${encodeURIComponent(id)}`, signal), id);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  return <TourView key={id} initial={loaded.value} query={query} />;
}

const viewOf = (step: TourStep): ViewState => stateFromQuery(new URLSearchParams(step.view));

function TourView({ initial, query }: { initial: Tour; query: URLSearchParams }) {
  const [tour, setTour] = useState(initial);
  const [at, setAt] = useState(Math.min(Math.max(Number(query.get("step") ?? 1) - 1, 0), Math.max(initial.steps.length - 1, 0)));
  const [editing, setEditing] = useState(query.get("edit") === "1");
  const viewer = useRef<Viewer | null>(null);
  const now = useRef<ViewState>(DEFAULT_VIEW);
  const step = tour.steps[at];
  const owner = session.value?.person?.role === "owner";
  const playing = query.has("play") && !editing && tour.steps.length > 0;
  const move = (to: number, options: { play?: boolean } = {}) => {
    setAt(to);
    const params = new URLSearchParams(to ? { step: String(to + 1) } : {});
    if (editing) params.set("edit", "1");
    if (options.play) params.set("play", "1");
    replaceQuery(params);
  };
  useEffect(() => {
    if (!playing) return;
    const timer = setTimeout(() => move((at + 1) % tour.steps.length, { play: true }), PLAY_MS);
    const stop = () => move(at);
    addEventListener("pointerdown", stop);
    addEventListener("keydown", stop);
    return () => {
      clearTimeout(timer);
      removeEventListener("pointerdown", stop);
      removeEventListener("keydown", stop);
    };
  }, [playing, at]);
  useEffect(() => {
    if (step && viewer.current) viewer.current.animateTo(viewOf(step), ANIMATION_MS);
  }, [at]);
  const onViewer = (ready: Viewer | null) => {
    viewer.current = ready;
    if (ready && step) {
      now.current = ready.state;
      ready.animateTo(viewOf(step), ANIMATION_MS);
    }
  };
  return (
    <article class={editing ? "work tour editing" : "work tour"}>
      <div class="work-stage">
        {step ? <StepViewer key={step.work} step={step} onViewer={onViewer} onState={(state) => (now.current = state)} /> : <p class="nothing">{t("tourEmpty")}</p>}
      </div>
      <aside class="label">
        <h1>{localize(tour.title)}</h1>
        {owner && (
          <button type="button" class="quiet" onClick={() => setEditing(!editing)}>
            <Icon name={editing ? "play" : "edit"} />{t(editing ? "doneEditing" : "editTour")}
          </button>
        )}
        {editing ? (
          <TourEditor tour={tour} at={at} onMove={move} onChange={setTour} view={() => stateToQuery(now.current).toString()} />
        ) : (
          step && <StepText tour={tour} at={at} step={step} move={move} />
        )}
      </aside>
    </article>
  );
}

function StepViewer({ step, onViewer, onState }: { step: TourStep; onViewer: (viewer: Viewer | null) => void; onState: (state: ViewState) => void }) {
  const loaded = useLoaded((signal) => loadWork(step.work, signal), step.work);
  const surface = useMemo(() => loaded.value && { facts: loaded.value.facts, title: loaded.value.work.title }, [loaded.value]);
  const [initial] = useState<ViewState>(() => ({ ...DEFAULT_VIEW, mode: viewOf(step).mode }));
  if (loaded.error) return <ErrorMessage error={loaded.error} retry={loaded.retry} />;
  if (!surface || !loaded.value) return <Loading />;
  const { work } = loaded.value;
  return (
    <>
      <ViewerPanel surface={surface} initial={initial} onViewer={onViewer} onState={onState} />
      <p class="note">
        <Facts items={[<a href={`#/works/${encodeURIComponent(work.id)}`}>{localize(work.title)}</a>, localize(work.hand), <Licence licence={work.licence} />, localize(surface.facts.source_text)]} />
      </p>
    </>
  );
}

function StepText({ tour, at, step, move }: { tour: Tour; at: number; step: TourStep; move: (to: number) => void }) {
  const last = at === tour.steps.length - 1;
  return (
    <section class="step-panel" aria-live="polite">
      <p class="note">{t("step", { k: at + 1, n: tour.steps.length })}</p>
      <h2>{withoutNumber(localize(step.title))}</h2>
      <p class="step-text">{localize(step.text)}</p>
      <div class="step-buttons">
        <button type="button" class="quiet" disabled={at === 0} onClick={() => move(at - 1)}><Icon name="previous" />{t("back")}</button>
        {last ? <a class="button" href={kiosk.value ? `#${kiosk.value.path}` : "#/tours"}>{t("finish")}</a> : <button type="button" onClick={() => move(at + 1)}>{t("onward")}<Icon name="next" /></button>}
      </div>
      <ol class="dots">
        {tour.steps.map((s, k) => (
          <li key={k}><button type="button" aria-current={k === at ? "step" : undefined} aria-label={`${k + 1}. ${withoutNumber(localize(s.title))}`} onClick={() => move(k)} /></li>
        ))}
      </ol>
    </section>
  );
}
