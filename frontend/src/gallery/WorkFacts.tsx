import { say, words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import type { ViewerFacts, Work } from "../types";
import { length } from "../viewer/figures";
import { licenceName, scriptName } from "./scripts";

const t = words(table);

type Told = Pick<
  Work,
  "title" | "hand" | "period" | "dynasty" | "script" | "material" | "source" | "licence" | "attribution" | "collection" | "collection_title"
>;

/** The label beside a work, as in a museum; nothing of it is folded away. `alone`: in a page with no gallery around it. */
export function WorkFacts({ work, facts, alone = false }: { work: Told; facts: ViewerFacts; alone?: boolean }) {
  const rows: [Parameters<typeof t>[0], string][] = [
    ["dynasty", say(work.period) || work.dynasty],
    ["script", scriptName(work.script)],
    ["material", say(work.material)],
    ["size", size(facts)],
    ["source", work.source],
    ["licence", licenceName(work.licence)],
    ["attribution", work.attribution],
  ];
  return (
    <header class="facts">
      <h1>{say(work.title)}</h1>
      <p class="by">{say(work.hand)}</p>
      <p class={`height-from ${facts.source}`}>
        <strong>{t("heightFrom")}</strong>
        {say(facts.source_text)}
      </p>
      <dl aria-label={t("facts")}>
        {rows.filter(([, value]) => value).map(([name, value]) => (
          <div key={name}>
            <dt>{t(name)}</dt>
            <dd><Linked text={value} /></dd>
          </div>
        ))}
        <div>
          <dt>{t("collection")}</dt>
          <dd>{alone ? say(work.collection_title) : <a href={`#/?collection=${encodeURIComponent(work.collection)}`}>{say(work.collection_title) || work.collection}</a>}</dd>
        </div>
      </dl>
    </header>
  );
}

function size({ width, height, spacing, unit }: ViewerFacts): string {
  return unit === "mm" ? `${length(width * spacing, unit)} × ${length(height * spacing, unit)}` : `${width} × ${height} px`;
}

/** Plain text in which web addresses can be followed. */
export function Linked({ text }: { text: string }) {
  const parts = text.split(/(https?:\/\/[^\s,;)）。，；]+)/);
  return <>{parts.map((part, k) => (k % 2 ? <a key={k} href={part} rel="noopener noreferrer" target="_blank">{part}</a> : part))}</>;
}
