// The studio: a master, a sheet to write on, and the mark.

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { get, session } from "../api";
import { say, t } from "../i18n";
import type { PageProps } from "../router";
import type { Attempt, Work } from "../types";
import { PageTrouble, Trouble, useLoaded, Waiting } from "../ui";
import { CropPhoto } from "./CropPhoto";
import { add, canRedo, canUndo, clear, redo, undo, written, type History } from "./ink/history";
import { picture } from "./ink/painting";
import { sheetOf } from "./ink/stroke";
import { MarkView } from "./mark/MarkView";
import { loginLink } from "./login";
import { AUTO_AFTER, useMarking, type Copy, type Marked } from "./marking";
import { w } from "./say";
import { draftOf, keepDraft, keepRecent, keepSettings, keptSettings, type WritingSettings } from "./settings";
import { Tabs } from "./Tabs";
import { Tools } from "./Tools";
import { WritingCell } from "./WritingCell";
import "./studio.css";

const WAYS = ["pen", "photo"] as const;
type Way = (typeof WAYS)[number];

export default function Write({ params, query }: PageProps) {
  const id = params["id"] ?? "";
  const loaded = useLoaded((signal) => get<Work>(`/api/works/${encodeURIComponent(id)}`, signal), id);
  if (loaded.error) return <PageTrouble error={loaded.error} again={loaded.again} />;
  if (!loaded.value) return <Waiting />;
  return <Desk key={id} work={loaded.value} task={query.get("task")} />;
}

function Desk({ work, task }: { work: Work; task: string | null }) {
  const [way, setWay] = useState<Way>("pen");
  const [history, setHistory] = useState<History>(() => written(draftOf(work.id)));
  const [settings, setSettings] = useState<WritingSettings>(keptSettings);
  const [cell, setCell] = useState<{ make: (() => Promise<Blob>) | null }>({ make: null });
  // a task takes copies of the class's pupils; to their teacher it is a link back
  const pupil = session.value?.person?.role === "pupil";
  const { marked, ask, drop } = useMarking(work.id, pupil ? task : null);
  const [writing, setWriting] = useState(false);
  const strokes = history.done;
  const change = (step: (history: History) => History) => {
    drop();
    setHistory(step);
  };
  const adjust = (part: Partial<WritingSettings>) => setSettings((old) => ({ ...old, ...part }));
  const make = copyOf(way, strokes, cell.make, settings);
  const mark = (tried = false) => void (make && ask(make, { tried }));
  useEffect(() => keepRecent(work.id), [work.id]);
  useEffect(() => keepSettings(settings), [settings]);
  useLayoutEffect(() => keepDraft(work.id, strokes), [strokes]); // at once: the next thing may be another page
  useAutoMark(settings.auto && !writing && way === "pen" && strokes.length > 0, strokes, () => mark(true));
  useKeys({ undo: () => change(undo), redo: () => change(redo), mark: () => mark() });
  return (
    <div class="desk">
      <Heading work={work} task={task} />
      <section class="desk-sheet" aria-label={w("sheet")}>
        <Tabs names={WAYS} chosen={way} onChoose={(next) => (drop(), setWay(next))} label={w("ways")} title={(name) => w(name)}>
          {way === "pen" ? (
            <WritingCell
              {...settings} strokes={strokes} work={work} onHand={(down) => (setWriting(down), down && drop())}
              onStroke={(stroke) => change((old) => add(old, stroke))}
            />
          ) : (
            <CropPhoto grid={settings.grid} onCell={(next) => (drop(), setCell({ make: next }))} />
          )}
        </Tabs>
        <div class="row desk-actions">
          {way === "pen" && <HistoryButtons history={history} onChange={change} />}
          <button type="button" class="mark-it" disabled={!make || marked.state === "asking"} onClick={() => mark()}>
            {marked.state === "asking" ? w("marking") : w("markIt")}
          </button>
        </div>
        {way === "pen" && (
          <>
            <Tools settings={settings} onChange={adjust} />
            <label class="check">
              <input type="checkbox" checked={settings.auto} onChange={(event) => adjust({ auto: event.currentTarget.checked })} />
              <span>{w("auto")}</span>
            </label>
          </>
        )}
        {!session.value?.person && <VisitorNote />}
      </section>
      <section class="desk-mark" aria-label={w("mark")}>
        <Announced marked={marked} />
        <Result marked={marked} work={work} forTask={pupil && task !== null} onAgain={() => mark()} />
      </section>
    </div>
  );
}

/** How to make what is sent to be marked; null while there is nothing to mark. */
function copyOf(
  way: Way, strokes: History["done"], cut: (() => Promise<Blob>) | null, { grid }: WritingSettings,
): (() => Promise<Copy>) | null {
  if (way === "photo") return cut && (async () => ({ kind: "photo", picture: await cut(), grid: "" }));
  if (!strokes.length) return null;
  return async () => ({ kind: "pen", picture: await picture(strokes), strokes: JSON.stringify(sheetOf(strokes)), grid });
}

function Heading({ work, task }: { work: Work; task: string | null }) {
  return (
    <header class="desk-head">
      <a href={`#/works/${work.id}`} class="desk-thumb">
        <img src={work.thumb} alt={w("seeMaster")} width="72" height="72" />
      </a>
      <div>
        <h1>{say(work.title)}</h1>
        <p class="note">
          {say(work.hand)} <span class="period">· {say(work.period)} </span>· <a href="#/studio">{w("otherMaster")}</a>
        </p>
        {task && (
          <p>
            <a href={`#/tasks/${task}`}>{w("forTask")}</a>
          </p>
        )}
      </div>
    </header>
  );
}

function HistoryButtons({ history, onChange }: { history: History; onChange: (step: (history: History) => History) => void }) {
  return (
    <>
      <button type="button" class="quiet" disabled={!canUndo(history)} onClick={() => onChange(undo)} title="Ctrl+Z">
        ↶ {w("undo")}
      </button>
      <button type="button" class="quiet" disabled={!canRedo(history)} onClick={() => onChange(redo)} title="Ctrl+Shift+Z">
        ↷ {w("redo")}
      </button>
      <button type="button" class="quiet" disabled={!history.done.length} onClick={() => onChange(clear)}>
        {w("clear")}
      </button>
    </>
  );
}

function VisitorNote() {
  return (
    <p class="visitor">
      {w("visitor")} <a href={loginLink()}>{t("login")}</a>
    </p>
  );
}

/** The mark for those who hear the page. */
function Announced({ marked }: { marked: Marked }) {
  return (
    <p class="visually-hidden" role="status" aria-live="polite">
      {marked.state === "asking" ? w("marking") : marked.state === "told" ? told(marked.attempt) : ""}
    </p>
  );
}

function told({ mark }: Attempt): string {
  if (mark.refused) return `${w("refusedTitle")} ${say(mark.refused)}`;
  const [low, high] = mark.interval ?? [0, 0];
  const score = mark.score?.toFixed(0) ?? "";
  return w("spoken", { score, level: say(mark.level_text), low: low.toFixed(0), high: high.toFixed(0), count: mark.remarks.length });
}

function Result({ marked, work, forTask, onAgain }: { marked: Marked; work: Work; forTask: boolean; onAgain: () => void }) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    // on a phone the mark stands below the sheet; a mark that came by itself must not move the page under the pen
    if (marked.state === "told" && !marked.tried) place.current?.scrollIntoView({ block: "nearest", behavior: "smooth" });
  }, [marked]);
  if (marked.state === "failed") return <Trouble error={marked.error} again={onAgain} />;
  if (marked.state !== "told")
    return (
      <div class="master-card">
        <img src={work.files?.picture ?? work.thumb} alt={say(work.title)} />
        <p class="note">{marked.state === "asking" ? w("marking") : w("beginHint")}</p>
      </div>
    );
  return (
    <div ref={place}>
      {marked.attempt.id ? (
        <p class="note kept">
          {w(forTask && !marked.attempt.task ? "keptLoose" : "kept")} <a href={`#/attempts/${marked.attempt.id}`}>{w("open")}</a> · <a href="#/practice">{t("practice")}</a>
        </p>
      ) : (
        session.value?.person && <p class="note kept">{w("tried")}</p>
      )}
      <MarkView attempt={marked.attempt} picture={marked.picture} />
    </div>
  );
}

function useAutoMark(on: boolean, strokes: readonly unknown[], mark: () => void): void {
  useEffect(() => {
    if (!on) return;
    const wait = setTimeout(mark, AUTO_AFTER);
    return () => clearTimeout(wait);
  }, [on, strokes]);
}

function useKeys(steps: { undo: () => void; redo: () => void; mark: () => void }): void {
  const latest = useRef(steps);
  latest.current = steps;
  useEffect(() => {
    const press = (event: KeyboardEvent) => {
      const target = event.target as HTMLElement;
      const undoing = (event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z";
      if (undoing && !(target instanceof HTMLTextAreaElement)) {
        event.preventDefault();
        (event.shiftKey ? latest.current.redo : latest.current.undo)();
      } else if (event.key === "Enter" && !target.closest("button, a, input, select, textarea, summary, dialog")) latest.current.mark();
    };
    addEventListener("keydown", press);
    return () => removeEventListener("keydown", press);
  }, []);
}
