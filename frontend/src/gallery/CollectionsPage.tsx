import { get, session } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { PageProps } from "../router";
import type { Collection, Page, WorkCard } from "../types";
import { ErrorPage, Facts, Loading, useLoaded } from "../ui";
import { CollectionTools } from "./CollectionTools";
import { RelitThumb } from "./GalleryCard";
import { Licence, translated } from "./licences";
import { TextWithLinks } from "./WorkFacts";
import "./gallery.css";
import "./work.css";

const THUMB_COUNT = 4;

export default function CollectionsPage(_: PageProps) {
  const loaded = useLoaded((signal) => get<Collection[]>("api/collections", signal), "all");
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const items = loaded.value;
  const owner = session.value?.person?.role === "owner";
  return (
    <>
      <header class="page-head">
        <h1>{t("collections")}</h1>
        <p class="lead">{t("collectionsLead")}</p>
      </header>
      {!items.length && <p class="nothing">{t("noCollections")}</p>}
      <ul class="collection-list">
        {items.map((item) => (
          <CollectionItem key={item.id} item={item} onChange={owner ? loaded.retry : null} />
        ))}
      </ul>
    </>
  );
}

/** onChange: given to an owner, who may change the collection. */
function CollectionItem({ item, onChange }: { item: Collection; onChange: (() => void) | null }) {
  const url = `api/works?collection=${encodeURIComponent(item.id)}&limit=${THUMB_COUNT}`;
  const works = useLoaded((signal) => get<Page<WorkCard>>(url, signal), item.id);
  return (
    <li class="collection-card">
      <a class="collection-works" href={`#/collections/${encodeURIComponent(item.id)}`} aria-label={localize(item.title)}>
        {/* places for those that have not arrived, so that what is below them does not move under a finger */}
        {Array.from({ length: Math.min(item.works, THUMB_COUNT) }, (_, k) => {
          const work = works.value?.items[k];
          return work ? <RelitThumb key={work.id} work={work} /> : <span key={k} class="thumb" />;
        })}
      </a>
      <div>
        <h2><a href={`#/collections/${encodeURIComponent(item.id)}`}>{localize(item.title)}</a></h2>
        {localize(item.note) && <p>{localize(item.note)}</p>}
        <p class="note">
          <Facts items={[t(item.works === 1 ? "countOne" : "count", { n: item.works.toLocaleString() }), item.licence && <>{t("licence")}{t("colon")}<Licence licence={item.licence} /></>]} />
        </p>
        {item.source && <p class="note"><TextWithLinks text={translated(item.source)} /></p>}
        {onChange && <CollectionTools item={item} onChange={onChange} />}
      </div>
    </li>
  );
}
