// A collection as an exhibition: a lit work at its head, what it is, its tour, and its works in the order of its owner.

import { useEffect, useState } from "preact/hooks";
import { get, put, session } from "../api";
import { LitWork } from "../home/LitWork";
import { common, localize } from "../i18n";
import { t } from "../i18n/gallery";
import { enterKiosk, kiosk, leaveKiosk, secondsOf } from "../kiosk";
import { navigate, type PageProps } from "../router";
import type { Exhibition, Page, WorkCard } from "../types";
import { ErrorMessage, ErrorPage, Facts, Loading, useLoaded } from "../ui";
import { Icon } from "../viewer/Icon";
import { collectionUrl, CollectionTools } from "./CollectionTools";
import { Licence, translated } from "./licences";
import { clearLastList } from "./listState";
import { ShareLink } from "./ShareWork";
import { TextWithLinks } from "./WorkFacts";
import { WorkList } from "./WorkList";
import "./gallery.css";
import "./work.css";

const MOST_ORDERED = 1000;
const BATCH = 200;

export default function CollectionPage({ params, query }: PageProps) {
  const id = params.id ?? "";
  const loaded = useLoaded((signal) => get<Exhibition>(collectionUrl({ id }), signal), id);
  const asked = query.get("kiosk");
  useEffect(() => {
    if (asked === "off") leaveKiosk();
    else if (asked !== null) enterKiosk({ path: `/collections/${id}`, seconds: secondsOf(asked) });
  }, [asked, id]);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  return <ExhibitionView key={id} shown={loaded.value} onChange={loaded.retry} />;
}

function ExhibitionView({ shown, onChange }: { shown: Exhibition; onChange: () => void }) {
  const [ordering, setOrdering] = useState(false);
  const [version, setVersion] = useState(0);
  const owner = session.value?.person?.role === "owner" && !kiosk.value;
  const filters = `collection=${encodeURIComponent(shown.id)}`;
  const changed = () => {
    clearLastList();
    setOrdering(false);
    setVersion(version + 1);
    onChange();
  };
  return (
    <article class="exhibition">
      <div class={shown.cover ? "home" : ""}>
        {shown.cover && <LitWork work={shown.cover} />}
        <div class="home-words">
          <h1>{localize(shown.title)}</h1>
          {localize(shown.note).split(/\n+/).filter(Boolean).map((text, k) => <p key={k}>{text}</p>)}
          {shown.tour && (
            <p class="row">
              <a class="button" href={`#/tours/${encodeURIComponent(shown.tour.id)}`}><Icon name="play" />{t("begin")}</a>
              <span>{localize(shown.tour.title)}</span>
            </p>
          )}
          <p class="note"><Facts items={[t(shown.works === 1 ? "countOne" : "count", { n: shown.works.toLocaleString() }), shown.licence && <>{t("licence")}{t("colon")}<Licence licence={shown.licence} /></>]} /></p>
          {shown.source && <p class="note"><TextWithLinks text={translated(shown.source)} /></p>}
          {!kiosk.value && (
            <>
              <p class="row note"><a href={`#/gallery?${filters}`}>{t("searchWithin")}</a></p>
              <details class="share">
                <summary>{t("share")}</summary>
                <ShareLink path={`collections/${encodeURIComponent(shown.id)}`} />
                <p class="note">{t("kioskHint")} <a href={`#/collections/${encodeURIComponent(shown.id)}?kiosk=90`}>{t("kioskStart")}</a></p>
              </details>
            </>
          )}
          {owner && <CollectionTools item={shown} onChange={shown.works ? changed : () => navigate("/collections")} />}
          {owner && shown.works > 1 && !ordering && <button type="button" class="quiet small" onClick={() => setOrdering(true)}>{t("order")}</button>}
        </div>
      </div>
      {ordering ? (
        <OrderWorks shown={shown} onDone={changed} onCancel={() => setOrdering(false)} />
      ) : (
        <WorkList key={version} name={`exhibition ${shown.id}`} filters={{ collection: shown.id }} />
      )}
    </article>
  );
}

/** The first works of a collection in a list that an owner puts in order. */
function OrderWorks({ shown, onDone, onCancel }: { shown: Exhibition; onDone: () => void; onCancel: () => void }) {
  const loaded = useLoaded((signal) => firstWorks(shown.id, signal), shown.id);
  const [order, setOrder] = useState<WorkCard[] | null>(null);
  const [error, setError] = useState<unknown>(null);
  const works = order ?? loaded.value;
  if (loaded.error) return <ErrorMessage error={loaded.error} retry={loaded.retry} />;
  if (!works) return <Loading />;
  const save = () => put(`${collectionUrl(shown)}/order`, { works: works.map((work) => work.id) }).then(onDone, setError);
  return (
    <section aria-label={t("order")}>
      <p class="row">
        <button type="button" onClick={() => void save()}>{common("save")}</button>
        <button type="button" class="quiet" onClick={onCancel}>{common("cancel")}</button>
      </p>
      {error !== null && <ErrorMessage error={error} />}
      <ol class="picker ordered">
        {works.map((work, at) => (
          <li key={work.id}>
            <img src={work.thumb} alt="" width="96" height="96" loading="lazy" />
            <span>{localize(work.title)}</span>
            <span class="row">
              <button type="button" class="quiet small" disabled={at === 0} aria-label={t("earlier", { title: localize(work.title) })} onClick={() => setOrder(moved(works, at, at - 1))}><Icon name="previous" /></button>
              <button type="button" class="quiet small" disabled={at === 0} aria-label={t("toFront", { title: localize(work.title) })} onClick={() => setOrder(moved(works, at, 0))}>{t("front")}</button>
              <button type="button" class="quiet small" disabled={at === works.length - 1} aria-label={t("later", { title: localize(work.title) })} onClick={() => setOrder(moved(works, at, at + 1))}><Icon name="next" /></button>
            </span>
          </li>
        ))}
      </ol>
      {shown.works > works.length && <p class="note">{t("orderedFirst", { n: works.length })}</p>}
    </section>
  );
}

async function firstWorks(collection: string, signal: AbortSignal): Promise<WorkCard[]> {
  const works: WorkCard[] = [];
  for (let total = 1; works.length < Math.min(total, MOST_ORDERED); ) {
    const page = await get<Page<WorkCard>>(`api/works?collection=${encodeURIComponent(collection)}&offset=${works.length}&limit=${BATCH}`, signal);
    if (!page.items.length) break;
    works.push(...page.items);
    total = page.total;
  }
  return works;
}

/** The list with one item taken to another place. */
export function moved<T>(items: T[], from: number, to: number): T[] {
  const rest = items.filter((_, at) => at !== from);
  return [...rest.slice(0, to), items[from]!, ...rest.slice(to)];
}
