// The works that match some filters, page after page as one scrolls down.

import { useEffect, useRef, useState } from "preact/hooks";
import { get, query as asQuery } from "../api";
import { t } from "../i18n/gallery";
import { replaceQuery } from "../router";
import type { FoundWorks, Understood, WorkCard } from "../types";
import { ErrorMessage, Facts, Loading } from "../ui";
import { GalleryCard } from "./GalleryCard";
import { wordsUnderstood } from "./labels";
import { type Filters, lastList, storeLastList, without, writeFilters } from "./listState";
import "./gallery.css";

const PAGE = 60;

/** name: under which the list is kept, so that one comes back to the place where one was. */
export function WorkList({ name, filters }: { name: string; filters: Filters }) {
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
