import { get } from "../api";
import { say, words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import type { PageProps } from "../router";
import type { Page, Text, WorkCard } from "../types";
import { PageTrouble, useLoaded, Waiting } from "../ui";
import { RelitThumb } from "./Card";
import { licenceName } from "./scripts";
import { Linked } from "./WorkFacts";
import "./gallery.css";
import "./work.css";

const t = words(table);
const SHOWN = 4;

type Collection = { id: string; title: Text; note?: Text; source?: string; licence?: string; works?: number };

export default function Collections(_: PageProps) {
  const found = useLoaded((signal) => get<Collection[] | { items: Collection[] }>("/api/collections", signal), "all");
  if (found.error) return <PageTrouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  const items = Array.isArray(found.value) ? found.value : found.value.items;
  return (
    <>
      <header class="page-head">
        <h1>{t("collections")}</h1>
        <p class="lead">{t("collectionsLead")}</p>
      </header>
      {!items.length && <p class="nothing">{t("noCollections")}</p>}
      <ul class="rooms">
        {items.map((item) => (
          <Room key={item.id} item={item} />
        ))}
      </ul>
    </>
  );
}

function Room({ item }: { item: Collection }) {
  const url = `/api/works?collection=${encodeURIComponent(item.id)}&limit=${SHOWN}`;
  const works = useLoaded((signal) => get<Page<WorkCard>>(url, signal), item.id);
  const count = item.works ?? works.value?.total;
  return (
    <li class="room">
      <a class="room-works" href={`#/?collection=${encodeURIComponent(item.id)}`} aria-label={say(item.title)}>
        {(works.value?.items ?? []).map((work) => (
          <RelitThumb key={work.id} work={work} />
        ))}
      </a>
      <div>
        <h2><a href={`#/?collection=${encodeURIComponent(item.id)}`}>{say(item.title)}</a></h2>
        {item.note && say(item.note) && <p>{say(item.note)}</p>}
        <p class="note">
          {count !== undefined && t(count === 1 ? "countOne" : "count", { n: count.toLocaleString() })}
          {item.licence && ` · ${t("licence")}: ${licenceName(item.licence)}`}
        </p>
        {item.source && <p class="note"><Linked text={item.source} /></p>}
      </div>
    </li>
  );
}
