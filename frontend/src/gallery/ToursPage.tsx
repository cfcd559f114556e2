import { useState } from "preact/hooks";
import { get, post, session } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import { navigate, type PageProps } from "../router";
import type { Tour } from "../types";
import { ErrorMessage, ErrorPage, Loading, useLoaded } from "../ui";
import { Icon } from "../viewer/Icon";
import { withoutNumber } from "./labels";
import "./gallery.css";
import "./work.css";

export default function ToursPage(_: PageProps) {
  const loaded = useLoaded((signal) => get<Tour[] | { items: Tour[] }>("api/tours", signal), "all");
  const [error, setError] = useState<unknown>(null);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const items = Array.isArray(loaded.value) ? loaded.value : loaded.value.items;
  const begin = async () => {
    try {
      const tour = await post<Tour>("api/tours", { title: { zh: "新導覽", en: "New tour" }, steps: [] });
      navigate(`/tours/${tour.id}?edit=1`);
    } catch (problem) {
      setError(problem);
    }
  };
  return (
    <>
      <header class="page-head">
        <h1>{t("tours")}</h1>
        <p class="lead">{t("toursLead")}</p>
        {session.value?.person?.role === "owner" && <button type="button" class="quiet" onClick={() => void begin()}><Icon name="add" />{t("newTour")}</button>}
      </header>
      {error ? <ErrorMessage error={error} /> : null}
      {!items.length && <p class="nothing">{t("noTours")}</p>}
      <ul class="collection-list">
        {items.map((tour) => (
          <li class="collection-card tour-card" key={tour.id}>
            <a class="collection-works" href={`#/tours/${tour.id}`} tabIndex={-1} aria-hidden="true">
              {[...new Set(tour.steps.map((step) => step.work))].slice(0, 4).map((work) => (
                <span class="thumb" key={work}><img src={`api/works/${encodeURIComponent(work)}/files/thumb`} alt="" loading="lazy" /></span>
              ))}
            </a>
            <div>
              <h2><a href={`#/tours/${tour.id}`}>{localize(tour.title)}</a></h2>
              <p class="note">{t("steps", { n: tour.steps.length })}</p>
              <ol class="contents">{tour.steps.slice(0, 5).map((step, k) => <li key={k}>{withoutNumber(localize(step.title))}</li>)}</ol>
              <a class="button" href={`#/tours/${tour.id}`}><Icon name="play" />{t("begin")}</a>
            </div>
          </li>
        ))}
      </ul>
    </>
  );
}
