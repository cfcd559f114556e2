// What one person has written: a curve for each master, best and last side by side, and every attempt.

import { useState } from "preact/hooks";
import { get, query, remove, session } from "../api";
import { formatDateTime, language, localize } from "../i18n";
import { t } from "../i18n/studio";
import { type PageProps, replaceQuery } from "../router";
import type { Attempt, Page, WorkCard } from "../types";
import { ErrorMessage, ErrorPage, Loading, useLoaded } from "../ui";
import { AttemptCard } from "./cards";
import { MarksChart, type ScorePoint } from "./MarksChart";
import { RequireLogin } from "../account/RequireLogin";

export type Practised = { work: WorkCard; count: number; best: number | null; last: number | null; first: number | null; curve: ScorePoint[] };

export default function PracticePage({ query: asked }: PageProps) {
  return (
    <RequireLogin why={t("practiceNeeds")}>
      <PracticeView chosen={asked.get("work")} person={asked.get("person")} />
    </RequireLogin>
  );
}

type PracticeData = { person: { id: string; name: string }; works: Practised[] };

/** person: a pupil whose practice a teacher looks at; one's own otherwise. */
function PracticeView({ chosen, person }: { chosen: string | null; person: string | null }) {
  const [work, setWork] = useState(chosen);
  const loaded = useLoaded((signal) => get<PracticeData>(`/api/practice${query({ person })}`, signal), `practice ${person}`);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const { works, person: whose } = loaded.value;
  const own = whose.id === session.value?.person?.id;
  const title = own ? t("practiceTitle") : t("practiceOf", { name: whose.name });
  const shown = works.find((one) => one.work.id === work) ?? works[0];
  const choose = (id: string) => {
    setWork(id);
    replaceQuery(new URLSearchParams(query({ work: id, person }).slice(1)));
  };
  if (!shown)
    return (
      <div class="need panel">
        <h1>{title}</h1>
        <p>{own ? t("practiceEmpty") : t("nothingYet")}</p>
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
          <a class="button quiet" href={`/api/practice.csv${query({ person })}`} download="practice.csv">
            CSV
          </a>
          <a class="button quiet" href={`/api/practice.pdf${query({ work: shown.work.id, person, language: language.value })}`} target="_blank" rel="noreferrer">
            {t("pdf")}
          </a>
        </p>
      </header>
      <ul class="practice-works" aria-label={t("masters")}>
        {works.map((one) => (
          <li key={one.work.id}>
            <button type="button" class="practice-work" aria-pressed={one === shown} onClick={() => choose(one.work.id)}>
              <img src={one.work.thumb} alt="" width="56" height="56" />
              <span>
                <b>{localize(one.work.title)}</b>
                <small>{t("times", { count: one.count })}</small>
              </span>
            </button>
          </li>
        ))}
      </ul>
      <WorkPractice key={shown.work.id} practised={shown} person={whose.id} own={own} onChange={loaded.retry} />
    </div>
  );
}

type WorkPracticeProps = { practised: Practised; person: string; own: boolean; onChange: () => void };

function WorkPractice({ practised, person, own, onChange }: WorkPracticeProps) {
  const { work, curve } = practised;
  return (
    <div class="practice-one">
      <section class="panel">
        <h2>{localize(work.title)}</h2>
        <MarksChart points={curve} title={localize(work.title)} />
        <p class="note">{t("curveNote")}</p>
        {own && (
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
  const best = marked.reduce<ScorePoint | null>((loaded, point) => (loaded && loaded.score! >= point.score! ? loaded : point), null);
  const ids = [best?.id, curve.at(-1)?.id].filter((id): id is string => id !== undefined);
  const loaded = useLoaded((signal) => Promise.all(ids.map((id) => get<Attempt>(`/api/attempts/${id}`, signal))), ids.join(" "));
  return (
    <section class="panel" aria-label={t("bestAndLast")}>
      <h2>{t("bestAndLast")}</h2>
      {loaded.error ? <ErrorMessage error={loaded.error} retry={loaded.retry} /> : !loaded.value && <Loading />}
      <div class="side-by-side">
        {loaded.value?.map((attempt, k) => (
          <AttemptCard key={k} attempt={attempt} title={t(best && k === 0 ? "best" : "last")} />
        ))}
      </div>
    </section>
  );
}

const PAGE_SIZE = 24;

function Attempts({ work, person, onChange }: { work: WorkCard; person: string; onChange: () => void }) {
  const [limit, setLimit] = useState(PAGE_SIZE);
  const [asking, setAsking] = useState<string | null>(null);
  const [error, setError] = useState<unknown>(null);
  const url = `/api/attempts${query({ work: work.id, person, limit })}`;
  const loaded = useLoaded((signal) => get<Page<Attempt>>(url, signal), url);
  const drop = (id: string) => {
    setAsking(null);
    remove(`/api/attempts/${id}`).then(() => (loaded.retry(), onChange()), setError);
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
                <button type="button" onClick={() => drop(attempt.id!)}>{t("deleteYes")}</button>
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
