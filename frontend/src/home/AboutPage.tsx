import { useEffect, useRef } from "preact/hooks";
import { get, session } from "../api";
import { common, localize } from "../i18n";
import { t } from "../i18n/home";
import type { Bilingual } from "../types";
import type { PageProps } from "../router";
import { useLoaded } from "../ui";
import { Licence, translated } from "../gallery/licences";
import { TextWithLinks } from "../gallery/WorkFacts";
import "./home.css";

type Credited = { id: string; title: Bilingual; source: string; licence: string };

/** `?part=` scrolls to a part, as the links at the foot of every page do. */
export default function AboutPage({ query }: PageProps) {
  const collections = useLoaded((signal) => get<Credited[]>("api/collections", signal), "all");
  const part = query.get("part");
  const root = useRef<HTMLElement>(null);
  useEffect(() => {
    if (part) root.current?.querySelector(`#${CSS.escape(part)}`)?.scrollIntoView();
  }, [part, collections.value]);
  return (
    <article class="about" ref={root}>
      <header class="page-head"><h1>{t("about")}</h1></header>
      <p>{t("first")}</p>
      <p>{t("second")} {t("third")}</p>
      <section id="marks">
        <h2>{t("aboutMarks")}</h2>
        {(["marksAre", "marksFrom", "marksCompare", "marksRefuse"] as const).map((name) => <p key={name}>{t(name)}</p>)}
      </section>
      <section id="heights">
        <h2>{t("aboutHeights")}</h2>
        <ul>{(["photometric", "inflation", "density"] as const).map((source) => <li key={source}>{common(source)}</li>)}</ul>
      </section>
      <section id="licences">
        <h2>{t("aboutLicences")}</h2>
        <dl>
          {(collections.value ?? []).map((item) => (
            <div key={item.id}>
              <dt><a href={`#/gallery?collection=${encodeURIComponent(item.id)}`}>{localize(item.title)}</a></dt>
              <dd>
                {item.licence && <Licence licence={item.licence} />} {item.source && <TextWithLinks text={translated(item.source)} />}
              </dd>
            </div>
          ))}
        </dl>
        <p>{t("software", { version: session.value?.version ?? "" })} · <a href="api/docs">{t("api")}</a></p>
      </section>
    </article>
  );
}
