import { useEffect, useRef, useState } from "preact/hooks";
import { get, query as asQuery, session } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import { type PageProps, replaceQuery } from "../router";
import type { Facet, Facets, FoundWorks, Understood, WorkCard } from "../types";
import { ErrorMessage, Facts, Loading, useLoaded } from "../ui";
import { Icon } from "../viewer/Icon";
import { dynasties, type FilterName, FILTERS, type Filters, lastList, readFilters, storeLastList, without, writeFilters } from "./listState";
import { GalleryCard } from "./GalleryCard";
import { scriptName, wordsUnderstood } from "./labels";
import "./gallery.css";

const PAGE = 60;
const LONGEST_LIST = 400;
const TYPING_DELAY_MS = 250;

export default function GalleryPage({ query }: PageProps) {
  const filters = readFilters(query);
  const key = writeFilters(filters).toString();
  const change = (next: Filters) => replaceQuery(writeFilters(next));
  const facets = useLoaded((signal) => get<Facets>(`api/facets${asQuery(filters)}`, signal), key);
  useEffect(() => {
    if (facets.value) dynasties.value = new Map([...dynasties.value, ...facets.value.dynasty.map((f) => [f.value, f] as const)]);
  }, [facets.value]);
  const role = session.value?.person?.role;
  return (
    <div class="browse">
      <header class="browse-head">
        <h1 lang="zh-Hant">入木三分</h1>
        <p class="lead">{t("lead")}</p>
        <Search filters={filters} change={change} />
        {(role === "owner" || role === "teacher") && <a class="button quiet" href="#/add"><Icon name="add" />{t("add")}</a>}
      </header>
      <FilterBar filters={filters} facets={facets.value} change={change} />
      <WorkList key={key} name={key} filters={filters} />
    </div>
  );
}

function Search({ filters, change }: { filters: Filters; change: (next: Filters) => void }) {
  const [text, setText] = useState(filters.q ?? "");
  const timer = useRef(0);
  const latest = useRef(filters);
  latest.current = filters;
  useEffect(() => setText(filters.q ?? ""), [filters.q]);
  const type = (value: string) => {
    setText(value);
    clearTimeout(timer.current);
    timer.current = window.setTimeout(() => change({ ...latest.current, q: value.trim() }), TYPING_DELAY_MS);
  };
  return (
    <label class="search">
      <Icon name="search" />
      <span class="visually-hidden">{t("search")}</span>
      <input type="search" value={text} placeholder={t("searchHint")} onInput={(event) => type(event.currentTarget.value)} />
    </label>
  );
}

function FilterBar({ filters, facets, change }: { filters: Filters; facets: Facets | undefined; change: (next: Filters) => void }) {
  const set = (name: FilterName, value: string) => change({ ...filters, [name]: value || undefined });
  const any = FILTERS.some((name) => filters[name]) || filters.q;
  return (
    <div class="filters" role="group" aria-label={t("filters")}>
      <div class="chips" role="group" aria-label={t("script")}>
        <Chip label={t("every")} on={!filters.script} act={() => set("script", "")} />
        {(facets?.script ?? []).map((facet) => (
          <Chip key={facet.value} label={scriptName(facet.value) === facet.value ? localize(facet) : scriptName(facet.value)} count={facet.count} on={filters.script === facet.value}
            act={() => set("script", filters.script === facet.value ? "" : facet.value)} />
        ))}
      </div>
      <div class="selects">
        {FILTERS.filter((name) => name !== "script").map((name) => (
          <FilterSelect key={name} name={name} value={filters[name] ?? ""} facets={facets?.[name] ?? []} set={(value) => set(name, value)} />
        ))}
        {any && <button type="button" class="quiet" onClick={() => change({})}>{t("clear")}</button>}
      </div>
    </div>
  );
}

function Chip({ label, count, on, act }: { label: string; count?: number; on: boolean; act: () => void }) {
  return (
    <button type="button" class="chip" aria-pressed={on} onClick={act}>
      {label}
      {count !== undefined && <small>{count.toLocaleString()}</small>}
    </button>
  );
}

function FilterSelect({ name, value, facets, set }: { name: FilterName; value: string; facets: Facet[]; set: (value: string) => void }) {
  const known = facets.filter((facet) => facet.value !== "");
  if (!known.length && !value) return null;
  const options = known.slice(0, LONGEST_LIST);
  return (
    <label class={value ? "choice on" : "choice"}>
      <span>{t(name)}</span>
      <select value={value} onChange={(event) => set(event.currentTarget.value)}>
        <option value="">{t("every")}</option>
        {value && !options.some((facet) => facet.value === value) && <option value={value}>{value}</option>}
        {options.map((facet) => (
          <option key={facet.value} value={facet.value}>{localize(facet)} ({facet.count})</option>
        ))}
      </select>
    </label>
  );
}

function WorkList({ name, filters }: { name: string; filters: Filters }) {
  const known = lastList(name);
  const [items, setItems] = useState<WorkCard[]>(known?.items ?? []);
  const [total, setTotal] = useState<number | null>(known?.total ?? null);
  const [understood, setUnderstood] = useState<Understood[]>(known?.understood ?? []);
  const [error, setError] = useState<unknown>(null);
  const busy = useRef(false);
  const end = useRef<HTMLDivElement>(null);
  const alive = useRef(new AbortController());
  const more = async () => {
    if (busy.current) return;
    busy.current = true;
    setError(null);
    try {
      const url = `api/works${asQuery({ ...filters, offset: items.length, limit: PAGE })}`;
      const page = await get<FoundWorks>(url, alive.current.signal);
      setItems((before) => [...before, ...page.items]);
      setTotal(page.total);
      setUnderstood(page.understood);
    } catch (problem) {
      if (!alive.current.signal.aborted) setError(problem);
    } finally {
      busy.current = false;
    }
  };
  const hasMore = total === null || items.length < total;
  useEffect(() => {
    alive.current = new AbortController();
    if (known) scrollTo(0, known.scroll);
    return () => alive.current.abort();
  }, []);
  useEffect(() => {
    const note = () => total !== null && storeLastList({ key: name, items, total, understood, scroll: scrollY });
    note();
    addEventListener("scroll", note, { passive: true });
    return () => removeEventListener("scroll", note);
  }, [items, total, understood]);
  useEffect(() => {
    if (!hasMore || error || !end.current) return;
    const observer = new IntersectionObserver((entries) => entries.some((s) => s.isIntersecting) && void more(), { rootMargin: "900px" });
    observer.observe(end.current);
    return () => observer.disconnect();
  }, [items.length, hasMore, error]);
  return (
    <>
      <p class="count" role="status">{total === null ? "" : t(total === 1 ? "countOne" : "count", { n: total.toLocaleString() })}</p>
      <SearchMeanings understood={understood} />
      <ul class="cards">
        {items.map((work) => (
          <GalleryCard key={work.id} work={work} />
        ))}
      </ul>
      {total === 0 && (
        <p class="nothing">
          {t("nothing")} {filters.q && <button type="button" class="quiet" onClick={() => replaceQuery(writeFilters(without(filters, "q")))}>{t("clear")}</button>}
        </p>
      )}
      {error ? <ErrorMessage error={error} retry={() => void more()} /> : total === null && <Loading />}
      <div ref={end} class="list-end">
        {hasMore && total !== null && !error && <button type="button" class="quiet" onClick={() => void more()}>{t("more")}</button>}
      </div>
    </>
  );
}

/** What each word of the search was taken for, so that a result that surprises explains itself. */
export function SearchMeanings({ understood }: { understood: Understood[] }) {
  if (!understood.length) return null;
  return (
    <dl class="understood" aria-label={t("understood")}>
      {wordsUnderstood(understood).map(({ word, meanings }) => (
        <div key={word}><dt>{word}</dt><dd><Facts items={meanings} /></dd></div>
      ))}
    </dl>
  );
}
