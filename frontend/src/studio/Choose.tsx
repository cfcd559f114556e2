// Which master? The ones last practised first, then a search through all of them.

import { useEffect, useState } from "preact/hooks";
import { get, query, session } from "../api";
import { say, t } from "../i18n";
import { rewrite, type PageProps } from "../router";
import type { Attempt, Page, WorkCard } from "../types";
import { Trouble, useLoaded, Waiting } from "../ui";
import { w } from "./say";
import { recentWorks } from "./settings";
import "./studio.css";

const SCRIPTS = ["seal", "clerical", "regular", "running", "cursive"] as const;
const MANY = 36;
const TYPED = 250; // ms of rest before a search is asked

export default function Choose({ query: asked }: PageProps) {
  const [text, setText] = useState(asked.get("q") ?? "");
  const [script, setScript] = useState(asked.get("script") ?? "");
  const [limit, setLimit] = useState(MANY);
  const wanted = useRested(text, TYPED);
  const task = asked.get("task");
  useEffect(() => rewrite(new URLSearchParams(query({ q: wanted, script, task }).slice(1))), [wanted, script]);
  const url = `/api/works${query({ q: wanted, script, limit })}`;
  const found = useLoaded((signal) => get<Page<WorkCard>>(url, signal), url);
  const nothingAsked = !wanted && !script;
  return (
    <div class="choose">
      <h1>{w("chooseTitle")}</h1>
      <p class="lead">{w("chooseLead")}</p>
      <form class="row find-master" role="search" onSubmit={(event) => event.preventDefault()}>
        <label class="grow">
          <span class="visually-hidden">{w("search")}</span>
          <input type="search" value={text} placeholder={w("searchHint")} onInput={(event) => setText(event.currentTarget.value)} />
        </label>
        <label>
          <span class="visually-hidden">{w("script")}</span>
          <select value={script} onChange={(event) => setScript(event.currentTarget.value)}>
            <option value="">{w("allScripts")}</option>
            {SCRIPTS.map((name) => (
              <option key={name} value={name}>
                {t(name)}
              </option>
            ))}
          </select>
        </label>
      </form>
      {nothingAsked && <Recent />}
      <h2>{nothingAsked ? w("allMasters") : w("found", { count: found.value?.total ?? "…" })}</h2>
      {found.error ? <Trouble error={found.error} again={found.again} /> : !found.value ? <Waiting /> : <Cards works={found.value.items} />}
      {found.value && found.value.total > found.value.items.length && (
        <p class="row">
          <button type="button" class="quiet" onClick={() => setLimit(limit + MANY)}>
            {w("moreMasters", { count: found.value.total - found.value.items.length })}
          </button>
        </p>
      )}
    </div>
  );
}

function Cards({ works }: { works: WorkCard[] }) {
  if (!works.length) return <p class="note">{w("noMasters")}</p>;
  return (
    <ul class="masters">
      {works.map((work) => (
        <li key={work.id}>
          <a class="master" href={`#/studio/${encodeURIComponent(work.id)}`}>
            <img src={work.thumb} alt="" width="120" height="120" loading="lazy" />
            <b lang="zh-Hant">{work.character || say(work.title)}</b>
            <small>
              {work.script && t(work.script as (typeof SCRIPTS)[number])}
              <span>{say(work.hand)}</span>
            </small>
          </a>
        </li>
      ))}
    </ul>
  );
}

/** From the attempts of a person with a login, else from what this browser remembers. */
function Recent() {
  const person = session.value?.person?.id ?? "";
  const recent = useLoaded((signal) => recentCards(person, signal), person);
  if (!recent.value?.length) return null;
  return (
    <>
      <h2>{w("recent")}</h2>
      <Cards works={recent.value} />
    </>
  );
}

async function recentCards(person: string, signal: AbortSignal): Promise<WorkCard[]> {
  const practised = person
    ? (await get<Page<Attempt>>(`/api/attempts${query({ person, limit: 60 })}`, signal)).items.map((attempt) => attempt.work)
    : [];
  const known = new Set(practised.map((work) => work.id));
  const looked = recentWorks().filter((id) => !known.has(id));
  const rest = await Promise.all(
    looked.slice(0, 8).map((id) => get<WorkCard>(`/api/works/${encodeURIComponent(id)}`, signal).catch(() => null)),
  );
  const all = [...practised, ...rest.filter((work): work is WorkCard => work !== null)];
  return [...new Map(all.map((work) => [work.id, work])).values()].slice(0, 8);
}

function useRested<T>(value: T, ms: number): T {
  const [rested, setRested] = useState(value);
  useEffect(() => {
    const wait = setTimeout(() => setRested(value), ms);
    return () => clearTimeout(wait);
  }, [value]);
  return rested;
}
