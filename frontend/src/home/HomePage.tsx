import { useEffect } from "preact/hooks";
import { get } from "../api";
import { t } from "../i18n/home";
import { navigate, type PageProps } from "../router";
import type { Home } from "../types";
import { ErrorPage, Loading, useLoaded } from "../ui";
import { LitWork } from "./LitWork";
import "./home.css";

export default function HomePage({ query }: PageProps) {
  const loaded = useLoaded((signal) => get<Home>("api/home", signal), "home");
  const filters = query.toString();
  useEffect(() => {
    if (filters) navigate(`/gallery?${filters}`); // links of older versions, whose gallery stood here
  }, [filters]);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const { cover, works } = loaded.value;
  return (
    <div class="home">
      {cover ? <LitWork work={cover} /> : <p class="nothing">{t("empty")}</p>}
      <div class="home-words">
        <h1>{t("title")}</h1>
        <p>{t("first")}</p>
        <p>{t("second")}</p>
        <p>{t("third")}</p>
        <p class="row">
          <a class="button" href="#/gallery">{t("toGallery")}</a>
          <a class="button quiet" href="#/studio">{t("toStudio")}</a>
        </p>
        <p class="note">{t("works", { n: works.toLocaleString() })}</p>
      </div>
    </div>
  );
}
