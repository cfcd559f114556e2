// The choice of a master to write: those practised last, then a search in all of them.

import { useEffect, useState } from "preact/hooks";
import { get, query, session } from "../api";
import { common, localize } from "../i18n";
import { t as sheets } from "../i18n/sheets";
import { t } from "../i18n/studio";
import { type PageProps, replaceQuery } from "../router";
import { SCRIPTS } from "../gallery/labels";
import type { Attempt, Page, WorkCard } from "../types";
import { ErrorMessage, Loading, useDelayed, useLoaded } from "../ui";
import { recentWorks } from "./settings";
import "./studio.css";

const PAGE_SIZE = 36;
const TYPING_DELAY_MS = 250; // pause in typing after which the search starts

export default function ChooseMasterPage({ query: params }: PageProps) {
  const [text, setText] = useState(params.get("q") ?? "");
  const [script, setScript] = useState(params.get("script") ?? "");
  const [limit, setLimit] = useState(PAGE_SIZE);
  const search = useDelayed(text, TYPING_DELAY_MS);
  const task = params.get("task");
  useEffect(() => replaceQuery(new URLSearchParams(query({ q: search, script, task }).slice(1))), [search, script]);
  const url = `api/works${query({ q: search, script, limit, masters: "true" })}`;
  const loaded = useLoaded((signal) => get<Page<WorkCard>>(url, signal), url);
  const nothingAsked = !search && !script;
  return (
    <div class="choose">
      <h1>{t("chooseTitle")}</h1>
      <p class="lead">{t("chooseLead")}</p>
      <p class="row on-paper">
        <a class="button quiet" href="#/sheets/print">{sheets("printSheet")}</a>
        <a class="button quiet" href="#/sheets">{sheets("readSheet")}</a>
      </p>
      <form class="row find-master" role="search" onSubmit={(event) => event.preventDefault()}>
        <label class="grow">
          <span class="visually-hidden">{t("search")}</span>
          <input type="search" value={text} placeholder={t("searchHint")} onInput={(event) => setText(event.currentTarget.value)} />
        </label>
        <label>
          <span class="visually-hidden">{t("script")}</span>
          <select value={script} onChange={(event) => setScript(event.currentTarget.value)}>
            <option value="">{t("allScripts")}</option>
            {SCRIPTS.map((name) => (
              <option key={name} value={name}>
                {common(name)}
              </option>
            ))}
          </select>
        </label>
      </form>
      {nothingAsked && <Recent />}
      <h2>{nothingAsked ? t("allMasters") : t("found", { count: loaded.value?.total ?? "…" })}</h2>
      {loaded.error ? <ErrorMessage error={loaded.error} retry={loaded.retry} /> : !loaded.value ? <Loading /> : <MasterCards works={loaded.value.items} />}
      {loaded.value && loaded.value.total > loaded.value.items.length && (
        <p class="row">
          <button type="button" class="quiet" onClick={() => setLimit(limit + PAGE_SIZE)}>
            {t("moreMasters", { count: loaded.value.total - loaded.value.items.length })}
          </button>
        </p>
      )}
    </div>
  );
}

function MasterCards({ works }: { works: WorkCard[] }) {
  if (!works.length) return <p class="note">{t("noMasters")}</p>;
  return (
    <ul class="masters">
      {works.map((work) => (
        <li key={work.id}>
          <a class="master" href={`#/studio/${encodeURIComponent(work.id)}`}>
            <img src={work.thumb} alt="" width="120" height="120" loading="lazy" />
            <b lang="zh-Hant">{work.character || localize(work.title)}</b>
            <small>
              {work.script && common(work.script as (typeof SCRIPTS)[number])}
              <span>{localize(work.hand)}</span>
            </small>
          </a>
        </li>
      ))}
    </ul>
  );
}

/** From the attempts of a person who is logged in, and from what this browser remembers. */
function Recent() {
  const person = session.value?.person?.id ?? "";
  const recent = useLoaded((signal) => recentCards(person, signal), person);
  if (!recent.value?.length) return null;
  return (
    <>
      <h2>{t("recent")}</h2>
      <MasterCards works={recent.value} />
    </>
  );
}

async function recentCards(person: string, signal: AbortSignal): Promise<WorkCard[]> {
  const practised = person
    ? (await get<Page<Attempt>>(`api/attempts${query({ person, limit: 60 })}`, signal)).items.map((attempt) => attempt.work)
    : [];
  const known = new Set(practised.map((work) => work.id));
  const viewed = recentWorks().filter((id) => !known.has(id));
  const rest = await Promise.all(
    viewed.slice(0, 8).map((id) => get<WorkCard>(`api/works/${encodeURIComponent(id)}`, signal).catch(() => null)),
  );
  const all = [...practised, ...rest.filter((work): work is WorkCard => work !== null)];
  const masters = all.filter((work) => work.character);
  return [...new Map(masters.map((work) => [work.id, work])).values()].slice(0, 8);
}
