// One person's practice: for each master a chart of the marks, the best and the last attempt, and all attempts.

import { useState } from "preact/hooks";
import { get, query, remove, session } from "../api";
import { formatDateTime, language, localize } from "../i18n";
import { t } from "../i18n/studio";
import { type PageProps, replaceQuery } from "../router";
import type { Attempt, Page, WorkCard } from "../types";
import { ErrorMessage, ErrorPage, Loading, useLoaded } from "../ui";
import { AttemptCard } from "./cards";
import { MarksChart, type ScorePoint } from "./MarksChart";
import { Progress } from "./mark/Progress";
import { RequireLogin } from "../account/RequireLogin";

type Practised = { work: WorkCard; count: number; best: number | null; last: number | null; first: number | null; curve: ScorePoint[] };

export default function PracticePage({ query: params }: PageProps) {
  return (
    <RequireLogin reason={t("practiceNeeds")}>
      <PracticeView chosen={params.get("work")} person={params.get("person")} />
    </RequireLogin>
  );
}

type PracticeData = { person: { id: string; name: string }; works: Practised[] };

/** person: the pupil whose practice a teacher looks at; null for one's own. */
function PracticeView({ chosen, person }: { chosen: string | null; person: string | null }) {
  const [work, setWork] = useState(chosen);
  const loaded = useLoaded((signal) => get<PracticeData>(`api/practice${query({ person })}`, signal), `practice ${person}`);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const { works, person: writer } = loaded.value;
  const isOwn = writer.id === session.value?.person?.id;
  const title = isOwn ? t("practiceTitle") : t("practiceOf", { name: writer.name });
  const selected = works.find((one) => one.work.id === work) ?? works[0];
  const choose = (id: string) => {
    setWork(id);
    replaceQuery(new URLSearchParams(query({ work: id, person }).slice(1)));
  };
  if (!selected)
    return (
      <div class="need panel">
        <h1>{title}</h1>
        <p>{isOwn ? t("practiceEmpty") : t("nothingYet")}</p>
        <a class="button" href="#/studio">
          {t("toStudio")}
        </a>
      </div>
    );
  return (
    <div class="practice">
      <header class="page-head">
        <h1>{title}</h1>
        <p class="row">
          <a class="button quiet" href={`api/practice.csv${query({ person })}`} download="practice.csv">
            CSV
          </a>
          <a class="button quiet" href={`api/practice.pdf${query({ work: selected.work.id, person, language: language.value })}`} target="_blank" rel="noreferrer">
            {t("pdf")}
          </a>
        </p>
      </header>
      <ul class="practice-works" aria-label={t("masters")}>
        {works.map((one) => (
          <li key={one.work.id}>
            <button type="button" class="practice-work" aria-pressed={one === selected} onClick={() => choose(one.work.id)}>
              <img src={one.work.thumb} alt="" width="56" height="56" />
              <span>
                <b>{localize(one.work.title)}</b>
                <small>{t("times", { count: one.count })}</small>
              </span>
            </button>
          </li>
        ))}
      </ul>
      <WorkPractice key={selected.work.id} practised={selected} person={writer.id} isOwn={isOwn} onChange={loaded.retry} />
    </div>
  );
}

type WorkPracticeProps = { practised: Practised; person: string; isOwn: boolean; onChange: () => void };

function WorkPractice({ practised, person, isOwn, onChange }: WorkPracticeProps) {
  const { work, curve } = practised;
  return (
    <div class="practice-one">
      <section class="panel">
        <h2>{localize(work.title)}</h2>
        <MarksChart points={curve} title={localize(work.title)} />
        <p class="note">{t("curveNote")}</p>
        {isOwn && (
          <a class="button" href={`#/studio/${work.id}`}>
            {t("writeAgain")}
          </a>
        )}
      </section>
      <BestAndLast curve={curve} />
      <Attempts work={work} person={person} onChange={onChange} />
    </div>
  );
}

function BestAndLast({ curve }: { curve: ScorePoint[] }) {
  const marked = curve.filter((point) => point.score !== null);
  const best = marked.reduce<ScorePoint | null>((top, point) => (top && top.score! >= point.score! ? top : point), null);
  const ids = [best?.id, curve.at(-1)?.id].filter((id): id is string => id !== undefined);
  const loaded = useLoaded((signal) => Promise.all(ids.map((id) => get<Attempt>(`api/attempts/${id}`, signal))), ids.join(" "));
  const last = loaded.value?.at(-1);
  return (
    <section class="panel" aria-label={t("bestAndLast")}>
      <h2>{t("bestAndLast")}</h2>
      {loaded.error ? <ErrorMessage error={loaded.error} retry={loaded.retry} /> : !loaded.value && <Loading />}
      <div class="side-by-side">
        {loaded.value?.map((attempt, k) => (
          <AttemptCard key={k} attempt={attempt} title={t(best && k === 0 ? "best" : "last")} />
        ))}
      </div>
      {last?.progress && <Progress progress={last.progress} />}
    </section>
  );
}

const PAGE_SIZE = 24;

function Attempts({ work, person, onChange }: { work: WorkCard; person: string; onChange: () => void }) {
  const [limit, setLimit] = useState(PAGE_SIZE);
  const [asking, setAsking] = useState<string | null>(null);
  const [error, setError] = useState<unknown>(null);
  const url = `api/attempts${query({ work: work.id, person, limit })}`;
  const loaded = useLoaded((signal) => get<Page<Attempt>>(url, signal), url);
  const deleteAttempt = (id: string) => {
    setAsking(null);
    remove(`api/attempts/${id}`).then(() => (loaded.retry(), onChange()), setError);
  };
  if (loaded.error) return <ErrorMessage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const { items, total } = loaded.value;
  return (
    <section class="panel practice-all">
      <h2>{t("allAttempts", { count: total })}</h2>
      {error !== null && <ErrorMessage error={error} />}
      <ul class="attempts">
        {items.map((attempt) => (
          <li key={attempt.id}>
            <AttemptCard attempt={attempt} />
            {asking === attempt.id ? (
              <span class="row sure" role="group" aria-label={t("deleteSure")}>
                <button type="button" onClick={() => deleteAttempt(attempt.id!)}>{t("deleteYes")}</button>
                <button type="button" class="quiet" onClick={() => setAsking(null)}>{t("deleteNo")}</button>
              </span>
            ) : (
              <button type="button" class="quiet small" aria-label={t("deleteOne", { when: formatDateTime(attempt.created) })} onClick={() => setAsking(attempt.id)}>
                {t("delete")}
              </button>
            )}
          </li>
        ))}
      </ul>
      {total > items.length && (
        <button type="button" class="quiet" onClick={() => setLimit(limit + PAGE_SIZE)}>
          {t("moreAttempts", { count: total - items.length })}
        </button>
      )}
    </section>
  );
}
