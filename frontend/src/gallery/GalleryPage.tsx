import { useEffect, useRef, useState } from "preact/hooks";
import { get, query as asQuery, session } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import { type PageProps, replaceQuery } from "../router";
import type { Facet, Facets } from "../types";
import { useLoaded } from "../ui";
import { Icon } from "../viewer/Icon";
import { dynasties, type FilterName, FILTERS, type Filters, readFilters, writeFilters } from "./listState";
import { scriptName } from "./labels";
import { WorkList } from "./WorkList";
import "./gallery.css";

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
