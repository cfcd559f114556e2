// What one person has written: a curve for each master, best and last side by side, and every attempt.

import { useState } from "preact/hooks";
import { get, query, remove, session } from "../api";
import { language, say } from "../i18n";
import { rewrite, type PageProps } from "../router";
import type { Attempt, Page, WorkCard } from "../types";
import { PageTrouble, Trouble, useLoaded, Waiting } from "../ui";
import { AttemptCard } from "./AttemptCard";
import type { Point } from "./chart";
import { Curve, moment } from "./Curve";
import { NeedLogin } from "./NeedLogin";
import { w } from "./say";

export type Practised = { work: WorkCard; count: number; best: number | null; last: number | null; first: number | null; curve: Point[] };

export default function Practice({ query: asked }: PageProps) {
  return (
    <NeedLogin why={w("practiceNeeds")}>
      <Shown chosen={asked.get("work")} person={asked.get("person")} />
    </NeedLogin>
  );
}

type Told = { person: { id: string; name: string }; works: Practised[] };

/** person: a pupil whose practice a teacher looks at; one's own otherwise. */
function Shown({ chosen, person }: { chosen: string | null; person: string | null }) {
  const [work, setWork] = useState(chosen);
  const found = useLoaded((signal) => get<Told>(`/api/practice${query({ person })}`, signal), `practice ${person}`);
  if (found.error) return <PageTrouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  const { works, person: whose } = found.value;
  const own = whose.id === session.value?.person?.id;
  const title = own ? w("practiceTitle") : w("practiceOf", { name: whose.name });
  const shown = works.find((one) => one.work.id === work) ?? works[0];
  const choose = (id: string) => {
    setWork(id);
    rewrite(new URLSearchParams(query({ work: id, person }).slice(1)));
  };
  if (!shown)
    return (
      <div class="need panel">
        <h1>{title}</h1>
        <p>{own ? w("practiceEmpty") : w("nothingYet")}</p>
        <a class="button" href="#/studio">
          {w("toStudio")}
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
            {w("pdf")}
          </a>
        </p>
      </header>
      <ul class="practice-works" aria-label={w("masters")}>
        {works.map((one) => (
          <li key={one.work.id}>
            <button type="button" class="practice-work" aria-pressed={one === shown} onClick={() => choose(one.work.id)}>
              <img src={one.work.thumb} alt="" width="56" height="56" />
              <span>
                <b>{say(one.work.title)}</b>
                <small>{w("times", { count: one.count })}</small>
              </span>
            </button>
          </li>
        ))}
      </ul>
      <OneWork key={shown.work.id} practised={shown} person={whose.id} own={own} onChange={found.again} />
    </div>
  );
}

type OneProps = { practised: Practised; person: string; own: boolean; onChange: () => void };

function OneWork({ practised, person, own, onChange }: OneProps) {
  const { work, curve } = practised;
  return (
    <div class="practice-one">
      <section class="panel">
        <h2>{say(work.title)}</h2>
        <Curve points={curve} title={say(work.title)} />
        <p class="note">{w("curveNote")}</p>
        {own && (
          <a class="button" href={`#/studio/${work.id}`}>
            {w("writeAgain")}
          </a>
        )}
      </section>
      <BestAndLast curve={curve} />
      <Attempts work={work} person={person} onChange={onChange} />
    </div>
  );
}

function BestAndLast({ curve }: { curve: Point[] }) {
  const marked = curve.filter((point) => point.score !== null);
  const best = marked.reduce<Point | null>((found, point) => (found && found.score! >= point.score! ? found : point), null);
  const ids = [best?.id, curve.at(-1)?.id].filter((id): id is string => id !== undefined);
  const found = useLoaded((signal) => Promise.all(ids.map((id) => get<Attempt>(`/api/attempts/${id}`, signal))), ids.join(" "));
  return (
    <section class="panel" aria-label={w("bestAndLast")}>
      <h2>{w("bestAndLast")}</h2>
      {found.error ? <Trouble error={found.error} again={found.again} /> : !found.value && <Waiting />}
      <div class="side-by-side">
        {found.value?.map((attempt, k) => (
          <AttemptCard key={k} attempt={attempt} title={w(best && k === 0 ? "best" : "last")} />
        ))}
      </div>
    </section>
  );
}

const MANY = 24;

function Attempts({ work, person, onChange }: { work: WorkCard; person: string; onChange: () => void }) {
  const [limit, setLimit] = useState(MANY);
  const [asking, setAsking] = useState<string | null>(null);
  const [error, setError] = useState<unknown>(null);
  const url = `/api/attempts${query({ work: work.id, person, limit })}`;
  const found = useLoaded((signal) => get<Page<Attempt>>(url, signal), url);
  const drop = (id: string) => {
    setAsking(null);
    remove(`/api/attempts/${id}`).then(() => (found.again(), onChange()), setError);
  };
  if (found.error) return <Trouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  const { items, total } = found.value;
  return (
    <section class="panel practice-all">
      <h2>{w("allAttempts", { count: total })}</h2>
      {error !== null && <Trouble error={error} />}
      <ul class="attempts">
        {items.map((attempt) => (
          <li key={attempt.id}>
            <AttemptCard attempt={attempt} />
            {asking === attempt.id ? (
              <span class="row sure" role="group" aria-label={w("deleteSure")}>
                <button type="button" onClick={() => drop(attempt.id!)}>{w("deleteYes")}</button>
                <button type="button" class="quiet" onClick={() => setAsking(null)}>{w("deleteNo")}</button>
              </span>
            ) : (
              <button type="button" class="quiet small" aria-label={w("deleteOne", { when: moment(attempt.created) })} onClick={() => setAsking(attempt.id)}>
                {w("delete")}
              </button>
            )}
          </li>
        ))}
      </ul>
      {total > items.length && (
        <button type="button" class="quiet" onClick={() => setLimit(limit + MANY)}>
          {w("moreAttempts", { count: total - items.length })}
        </button>
      )}
    </section>
  );
}
