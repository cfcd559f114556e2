import { get } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { PageProps } from "../router";
import type { Bilingual, Page, WorkCard } from "../types";
import { ErrorPage, Facts, Loading, useLoaded } from "../ui";
import { RelitThumb } from "./GalleryCard";
import { licenceName } from "./labels";
import { TextWithLinks } from "./WorkFacts";
import "./gallery.css";
import "./work.css";

const THUMB_COUNT = 4;

type Collection = { id: string; title: Bilingual; note?: Bilingual; source?: string; licence?: string; works?: number };

export default function CollectionsPage(_: PageProps) {
  const loaded = useLoaded((signal) => get<Collection[] | { items: Collection[] }>("api/collections", signal), "all");
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const items = Array.isArray(loaded.value) ? loaded.value : loaded.value.items;
  return (
    <>
      <header class="page-head">
        <h1>{t("collections")}</h1>
        <p class="lead">{t("collectionsLead")}</p>
      </header>
      {!items.length && <p class="nothing">{t("noCollections")}</p>}
      <ul class="collection-list">
        {items.map((item) => (
          <CollectionItem key={item.id} item={item} />
        ))}
      </ul>
    </>
  );
}

function CollectionItem({ item }: { item: Collection }) {
  const url = `api/works?collection=${encodeURIComponent(item.id)}&limit=${THUMB_COUNT}`;
  const works = useLoaded((signal) => get<Page<WorkCard>>(url, signal), item.id);
  const count = item.works ?? works.value?.total;
  return (
    <li class="collection-card">
      <a class="collection-works" href={`#/?collection=${encodeURIComponent(item.id)}`} aria-label={localize(item.title)}>
        {(works.value?.items ?? []).map((work) => (
          <RelitThumb key={work.id} work={work} />
        ))}
      </a>
      <div>
        <h2><a href={`#/?collection=${encodeURIComponent(item.id)}`}>{localize(item.title)}</a></h2>
        {item.note && localize(item.note) && <p>{localize(item.note)}</p>}
        <p class="note">
          <Facts items={[count !== undefined && t(count === 1 ? "countOne" : "count", { n: count.toLocaleString() }), item.licence && `${t("licence")}: ${licenceName(item.licence)}`]} />
        </p>
        {item.source && <p class="note"><TextWithLinks text={item.source} /></p>}
      </div>
    </li>
  );
}
