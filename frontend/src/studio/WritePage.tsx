// The page to write on: a master, a cell or a photograph, and the mark.

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { get, session } from "../api";
import { common, formatDateTime, localize } from "../i18n";
import { t } from "../i18n/studio";
import type { PageProps } from "../router";
import type { Attempt, Work } from "../types";
import { ErrorMessage, ErrorPage, Facts, Loading, useLoaded } from "../ui";
import { MasterHeader } from "./cards";
import { MasterBeside } from "./MasterBeside";
import { CropPhoto, type MakeCell } from "./CropPhoto";
import { addStroke, canRedo, canUndo, clearStrokes, type History, historyOf, redo, serializeStrokes, undo } from "./ink/strokes";
import { strokesPicture } from "./ink/painting";
import { MarkView } from "./mark/MarkView";
import { loginLink } from "../account/RequireLogin";
import { AUTO_MARK_DELAY_MS, type Copy, type MarkingState, useMarking } from "./marking";
import { addRecentWork, loadDraft, loadSettings, saveDraft, saveSettings, type WritingSettings } from "./settings";
import { Tabs } from "./Tabs";
import { taskTitle, useTask } from "./tasks";
import { BrushTools } from "./BrushTools";
import { WritingCell } from "./WritingCell";
import "./studio.css";

const MEDIA = ["pen", "photo"] as const;
type Medium = (typeof MEDIA)[number];

export default function WritePage({ params, query }: PageProps) {
  const id = params["id"] ?? "";
  const loaded = useLoaded((signal) => get<Work>(`api/works/${encodeURIComponent(id)}`, signal), id);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  if (!loaded.value.character) return <NoMaster work={loaded.value} />;
  return <WriteView key={id} work={loaded.value} task={query.get("task")} />;
}

function NoMaster({ work }: { work: Work }) {
  return (
    <div class="need panel">
      <h1>{localize(work.title)}</h1>
      <p>{t("noMaster")}</p>
      <p class="row">
        <a class="button" href="#/studio">{t("otherMaster")}</a>
        <a class="button quiet" href={`#/works/${encodeURIComponent(work.id)}`}>{t("seeWork")}</a>
      </p>
    </div>
  );
}

function WriteView({ work, task }: { work: Work; task: string | null }) {
  const [medium, setMedium] = useState<Medium>("pen");
  const [history, setHistory] = useState<History>(() => historyOf(loadDraft(work.id)));
  const [settings, setSettings] = useState<WritingSettings>(loadSettings);
  const [cell, setCell] = useState<PhotoCell>({ make: null, framed: false });
  // only a pupil's copy counts for the task; for a teacher the task is just a link back
  const pupil = session.value?.person?.role === "pupil";
  const { marked, requestMark, discard } = useMarking(work.id, pupil ? task : null);
  const turnPhoto = useRef<((degrees: number) => void) | null>(null);
  const markNext = useRef(false); // as soon as the turned photograph has been cropped
  const [writing, setWriting] = useState(false);
  const strokes = history.done;
  const change = (step: (history: History) => History) => {
    discard();
    setHistory(step);
  };
  const adjust = (part: Partial<WritingSettings>) => setSettings((old) => ({ ...old, ...part }));
  const make = copyMaker(medium, strokes, cell, settings);
  const mark = (automatic = false) => void (make && requestMark(make, { automatic }));
  const turnAndMark = (degrees: number) => {
    markNext.current = true;
    turnPhoto.current?.(degrees);
  };
  const changeCell = (make: MakeCell | null, framed: boolean) => {
    discard();
    setCell({ make, framed });
    if (!make || !markNext.current) return;
    markNext.current = false;
    const cropped = copyMaker("photo", [], { make, framed }, settings);
    if (cropped) void requestMark(cropped, { automatic: false });
  };
  useEffect(() => addRecentWork(work.id), [work.id]);
  useEffect(() => saveSettings(settings), [settings]);
  useLayoutEffect(() => saveDraft(work.id, strokes), [strokes]); // before the page can change
  useAutoMark(settings.auto && !writing && medium === "pen" && strokes.length > 0, strokes, () => mark(true));
  useKeys({ undo: () => change(undo), redo: () => change(redo), mark: () => mark() });
  return (
    <div class="desk">
      <Heading work={work} task={task} />
      <MasterBeside work={work} marked={marked.state === "done"} />
      <section class="desk-sheet" aria-label={t("sheet")}>
        <Tabs names={MEDIA} chosen={medium} onChoose={(next) => (discard(), setMedium(next))} label={t("ways")} title={(name) => t(name)}>
          {medium === "pen" ? (
            <WritingCell
              {...settings} strokes={strokes} work={work} onWriting={(down) => (setWriting(down), down && discard())}
              onStroke={(stroke) => change((old) => addStroke(old, stroke))}
            />
          ) : (
            <CropPhoto grid={settings.grid} work={work} onCell={changeCell} onTurnable={(turn) => (turnPhoto.current = turn)} />
          )}
        </Tabs>
        <div class="row desk-actions">
          {medium === "pen" && <HistoryButtons history={history} onChange={change} />}
          <button type="button" class="mark-it" disabled={!make || marked.state === "asking"} onClick={() => mark()}>
            {marked.state === "asking" ? t("marking") : t("markIt")}
          </button>
        </div>
        {medium === "pen" && (
          <>
            <BrushTools settings={settings} onChange={adjust} />
            <label class="check">
              <input type="checkbox" checked={settings.auto} onChange={(event) => adjust({ auto: event.currentTarget.checked })} />
              <span>{t("auto")}</span>
            </label>
          </>
        )}
        {!session.value?.person && <VisitorNote />}
      </section>
      <section class="desk-mark" aria-label={t("mark")}>
        <MarkAnnouncement marked={marked} />
        <Result
          marked={marked} task={pupil ? task : null} onAgain={() => mark()} onTurn={medium === "photo" ? turnAndMark : null}
          onKeep={() => marked.state === "done" && void requestMark(async () => marked.copy, { automatic: false, unmarked: true })}
        />
      </section>
    </div>
  );
}

/** What is cropped from a photograph. framed: the crop is the printed cell. */
type PhotoCell = { make: MakeCell | null; framed: boolean };

/** A function that makes the copy to send; null while there is nothing to mark. */
function copyMaker(
  medium: Medium, strokes: History["done"], { make: cut, framed }: PhotoCell, { grid }: WritingSettings,
): (() => Promise<Copy>) | null {
  if (medium === "photo") return cut && (async () => ({ kind: "photo", picture: await cut(), grid: "", framed }));
  if (!strokes.length) return null;
  return async () => ({ kind: "pen", picture: await strokesPicture(strokes), strokes: JSON.stringify(serializeStrokes(strokes)), grid });
}

function Heading({ work, task }: { work: Work; task: string | null }) {
  const data = useTask(session.value?.person ? task : null);
  return (
    <MasterHeader work={work}>
      <h1>{localize(work.title)}</h1>
      <p class="note">
        <Facts items={[localize(work.hand), localize(work.period), <a href="#/studio">{t("otherMaster")}</a>]} />
      </p>
      {data && (
        <p>
          <a href={`#/tasks/${data.task.id}`}>{t("forTask", { title: taskTitle(data.task) })}</a>
        </p>
      )}
    </MasterHeader>
  );
}

function HistoryButtons({ history, onChange }: { history: History; onChange: (step: (history: History) => History) => void }) {
  return (
    <>
      <button type="button" class="quiet" disabled={!canUndo(history)} onClick={() => onChange(undo)} title="Ctrl+Z">
        ↶ {t("undo")}
      </button>
      <button type="button" class="quiet" disabled={!canRedo(history)} onClick={() => onChange(redo)} title="Ctrl+Shift+Z">
        ↷ {t("redo")}
      </button>
      <button type="button" class="quiet" disabled={!history.done.length} onClick={() => onChange(clearStrokes)}>
        {t("clear")}
      </button>
    </>
  );
}

function VisitorNote() {
  return (
    <p class="visitor">
      {t("visitor")} <a href={loginLink()}>{common("login")}</a>
    </p>
  );
}

/** The mark for screen readers. */
function MarkAnnouncement({ marked }: { marked: MarkingState }) {
  return (
    <p class="visually-hidden" role="status" aria-live="polite">
      {marked.state === "asking" ? t("marking") : marked.state === "done" ? spokenMark(marked.attempt) : ""}
    </p>
  );
}

function spokenMark({ id, mark }: Attempt): string {
  if (mark.refused && id) return t("keptUnmarked");
  if (mark.refused) return `${t("refusedTitle")} ${localize(mark.refused)}`;
  const [low, high] = mark.interval ?? [0, 0];
  const score = mark.score?.toFixed(0) ?? "";
  return t("spoken", { score, level: localize(mark.level_text), low: low.toFixed(0), high: high.toFixed(0), count: mark.remarks.length });
}

type ResultProps = {
  marked: MarkingState;
  /** The task that a pupil's copy is for. */
  task: string | null;
  onAgain: () => void;
  /** Turns the photograph by degrees clockwise and marks it; null if the copy is none. */
  onTurn: ((degrees: number) => void) | null;
  /** Keeps a copy that cannot be marked. */
  onKeep: () => void;
};

function Result({ marked, task, onAgain, onTurn, onKeep }: ResultProps) {
  const result = useRef<HTMLDivElement>(null);
  useEffect(() => {
    // on a phone the mark is below the cell; an automatic mark must not scroll the page under the pen
    if (marked.state === "done" && !marked.automatic) result.current?.scrollIntoView({ block: "nearest", behavior: "smooth" });
  }, [marked]);
  if (marked.state === "failed") return <ErrorMessage error={marked.error} retry={onAgain} />;
  if (marked.state !== "done") return <p class="note begin-hint">{marked.state === "asking" ? t("marking") : t("beginHint")}</p>;
  const { attempt, copy, automatic } = marked;
  const { refused } = attempt.mark;
  const degrees = refused?.turned_by;
  const canKeep = !attempt.id && !automatic && Boolean(session.value?.person);
  return (
    <div ref={result}>
      {attempt.id && attempt.task ? <HandedIn attempt={attempt} /> : attempt.id ? <Kept attempt={attempt} withdrawn={task !== null} /> : session.value?.person && !refused && <p class="note kept">{t("tried")}</p>}
      {attempt.id && refused ? null : (
        <MarkView
          attempt={attempt} picture={copy.picture}
          remedy={
            <p class="row">
              {degrees && onTurn ? <button type="button" onClick={() => onTurn(degrees)}>↻ {t("turnAndMark")}</button> : null}
              {canKeep && <button type="button" class="quiet" onClick={onKeep}>{t(task ? "handInUnmarked" : "keepUnmarked")}</button>}
            </p>
          }
        />
      )}
    </div>
  );
}

/** withdrawn: the copy was for a task that its teacher has taken back. */
function Kept({ attempt, withdrawn }: { attempt: Attempt; withdrawn: boolean }) {
  return (
    <p class="note kept">
      {t(withdrawn ? "keptLoose" : attempt.mark.refused ? "keptUnmarked" : "kept")}{" "}
      <Facts items={[<a href={`#/attempts/${attempt.id}`}>{t("open")}</a>, <a href="#/practice">{common("practice")}</a>]} />
    </p>
  );
}

function HandedIn({ attempt }: { attempt: Attempt }) {
  const data = useTask(attempt.task);
  return (
    <section class="handed-in panel" role="status">
      <h2>{t(attempt.mark.refused ? "handedInUnmarked" : "handedIn", { title: data ? taskTitle(data.task) : localize(attempt.work.title) })}</h2>
      <p>{t("handedInCounts", { when: formatDateTime(attempt.created) })}</p>
      <p class="row">
        <a class="button quiet" href={`#/tasks/${attempt.task}`}>{t("toTask")}</a>
        <a class="button quiet" href={`#/attempts/${attempt.id}`}>{t("open")}</a>
      </p>
    </section>
  );
}

function useAutoMark(on: boolean, strokes: readonly unknown[], mark: () => void): void {
  useEffect(() => {
    if (!on) return;
    const timer = setTimeout(mark, AUTO_MARK_DELAY_MS);
    return () => clearTimeout(timer);
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
