// Which of two copies is better? They are shown without marks and names.

import { useEffect, useRef, useState } from "preact/hooks";
import { get, post, query, session } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/studio";
import { type PageProps, replaceQuery } from "../router";
import type { Attempt, Page, WorkCard } from "../types";
import { ErrorMessage, Loading, useLoaded } from "../ui";
import { MasterPicture } from "./cards";
import { RequireLogin } from "../account/RequireLogin";

type Pair = { work: WorkCard; left: Attempt; right: Attempt; done: number; left_over: number };
const MANY = 200; // newest attempts, enough to find the masters that are being copied

type Winner = "left" | "right" | "same";
const WINNER_KEYS: Record<string, Winner> = { "1": "left", ArrowLeft: "left", "2": "right", ArrowRight: "right", "3": "same", ArrowDown: "same" };

export default function ComparePage({ query: params }: PageProps) {
  return (
    <RequireLogin reason={t("judgeNeeds")}>
      <CompareView params={params.get("work")} />
    </RequireLogin>
  );
}

function CompareView({ params }: { params: string | null }) {
  const [work, setWork] = useState(params);
  const [turn, setTurn] = useState(0);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const [before, setBefore] = useState<Pair | null>(null);
  const loaded = useLoaded((signal) => get<Pair | null>(`api/comparisons/next${query({ work })}`, signal), `${work} ${turn}`);
  const pair = loaded.fresh ? loaded.value : undefined;
  const began = useRef(0);
  useEffect(() => void (began.current = performance.now()), [pair]);
  const judge = async (winner: Winner) => {
    if (!pair || busy) return;
    setBusy(true);
    try {
      const seconds = Math.round(performance.now() - began.current) / 1000;
      await post("api/comparisons", { left: pair.left.id, right: pair.right.id, winner, seconds });
      setBefore(pair);
      setError(null);
      setTurn((n) => n + 1);
    } catch (reason) {
      setError(reason);
    } finally {
      setBusy(false);
    }
  };
  useCompareKeys(judge);
  return (
    <div class="judge">
      <header class="page-head">
        <h1>{t("judgeTitle")}</h1>
        <p class="row">
          <PickWork chosen={work} also={pair?.work ?? before?.work ?? null} onChoose={(id) => (setWork(id), replaceQuery(new URLSearchParams(query({ work: id }).slice(1))))} />
          {session.value?.person?.role !== "pupil" && (
            <a class="button quiet" href="api/comparisons.csv" download="comparisons.csv">
              CSV
            </a>
          )}
        </p>
      </header>
      {loaded.error || error ? <ErrorMessage error={loaded.error ?? error} retry={() => (setError(null), loaded.retry())} /> : null}
      {pair ? <PairView pair={pair} busy={busy} onJudge={judge} /> : pair === null ? <NoPairsLeft all={work === null} /> : !loaded.error && <Loading />}
      {before && <SimulatedNote pair={before} />}
    </div>
  );
}

function PairView({ pair, busy, onJudge }: { pair: Pair; busy: boolean; onJudge: (winner: Winner) => void }) {
  const all = pair.done + pair.left_over;
  return (
    <>
      <p class="lead">{t("judgeLead", { title: localize(pair.work.title) })}</p>
      <div class="judge-pair">
        {(["left", "right"] as const).map((side) => (
          <button key={side} type="button" class="judge-copy" disabled={busy} onClick={() => onJudge(side)}>
            <img src={pair[side].picture ?? ""} alt="" />
            <span>
              <kbd>{side === "left" ? "1" : "2"}</kbd> {t(side)}
            </span>
          </button>
        ))}
        <MasterFigure work={pair.work} />
      </div>
      <p class="row judge-same">
        <button type="button" class="quiet" disabled={busy} onClick={() => onJudge("same")}>
          <kbd>3</kbd> {t("same")}
        </button>
      </p>
      <p class="judge-progress">
        <progress max={all} value={pair.done} aria-label={t("progress")} />
        <span class="number">{t("judged", { done: pair.done, all })}</span>
      </p>
      <p class="note">{t("judgeNote")}</p>
    </>
  );
}

function MasterFigure({ work }: { work: WorkCard }) {
  return (
    <figure class="judge-master">
      <MasterPicture work={work} alt="" />
      <figcaption>{t("master")}</figcaption>
    </figure>
  );
}

/** Whether a copy was simulated is said only afterwards, when it cannot influence the judgement. */
function SimulatedNote({ pair }: { pair: Pair }) {
  const simulated = (["left", "right"] as const).filter((side) => pair[side].kind === "simulated");
  if (!simulated.length) return null;
  return (
    <p class="note" role="status">
      {t(simulated.length === 2 ? "bothSimulated" : simulated[0] === "left" ? "leftSimulated" : "rightSimulated")}
    </p>
  );
}

/** A choice of the masters whose copies can be compared. */
function PickWork({ chosen, also, onChoose }: { chosen: string | null; also: WorkCard | null; onChoose: (id: string | null) => void }) {
  const loaded = useLoaded((signal) => get<Page<Attempt>>(`api/attempts${query({ limit: MANY })}`, signal), "attempts");
  const works = worksToCompare(loaded.value?.items ?? []);
  if (also && !works.some((work) => work.id === also.id)) works.push(also);
  return (
    <label class="judge-pick">
      <span>{t("master")}</span>
      <select value={chosen ?? ""} onChange={(event) => (event.currentTarget.blur(), onChoose(event.currentTarget.value || null))}>
        <option value="">{t("anyMaster")}</option>
        {chosen && !works.some((work) => work.id === chosen) && <option value={chosen}>{chosen}</option>}
        {works.map((work) => (
          <option key={work.id} value={work.id}>
            {localize(work.title)}
          </option>
        ))}
      </select>
    </label>
  );
}

/** The characters with at least two marked attempts, each once. */
export function worksToCompare(attempts: readonly Pick<Attempt, "work" | "mark">[]): WorkCard[] {
  const marked = attempts.filter((one) => one.mark.score !== null && one.work.character).map((one) => one.work);
  const twice = marked.filter((work, k) => marked.slice(0, k).some((other) => other.id === work.id));
  return [...new Map(twice.map((work) => [work.id, work])).values()];
}

function NoPairsLeft({ all }: { all: boolean }) {
  return (
    <div class="need panel">
      <p>{t(all ? "judgeDone" : "judgeDoneWork")}</p>
      <a class="button quiet" href="#/studio">
        {t("toStudio")}
      </a>
    </div>
  );
}

function useCompareKeys(judge: (winner: Winner) => void): void {
  const latest = useRef(judge);
  latest.current = judge;
  useEffect(() => {
    const press = (event: KeyboardEvent) => {
      const winner = WINNER_KEYS[event.key];
      if (!winner || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
      if ((event.target as HTMLElement).closest("input, select, textarea")) return;
      event.preventDefault();
      latest.current(winner);
    };
    addEventListener("keydown", press);
    return () => removeEventListener("keydown", press);
  }, []);
}
