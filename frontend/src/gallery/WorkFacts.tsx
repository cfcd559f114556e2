import type { ComponentChildren } from "preact";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { ViewerFacts, Work } from "../types";
import { formatLength } from "../viewer/scales";
import { Licence, translated } from "./licences";
import { scriptName } from "./labels";

type WorkTexts = Pick<
  Work,
  "title" | "hand" | "period" | "dynasty" | "script" | "material" | "width" | "height" | "source" | "licence" | "attribution" | "collection" | "collection_title"
>;

/** The label beside a work, as in a museum. `facts`: null where no surface can be made of it. `alone`: in a page without the gallery, so that nothing links to it. */
export function WorkFacts({ work, facts, alone = false }: { work: WorkTexts; facts: ViewerFacts | null; alone?: boolean }) {
  const rows: [Parameters<typeof t>[0], ComponentChildren][] = [
    ["dynasty", localize(work.period) || work.dynasty],
    ["script", scriptName(work.script)],
    ["material", localize(work.material)],
    ["size", <Size work={work} facts={facts} />],
    ["source", work.source && <TextWithLinks text={translated(work.source)} />],
    ["licence", <Licence licence={work.licence} />],
    ["attribution", work.attribution && <TextWithLinks text={translated(work.attribution)} />],
  ];
  return (
    <header class="facts">
      <h1>{localize(work.title)}</h1>
      <p class="by">{localize(work.hand)}</p>
      {facts && (
        <p class={`height-from ${facts.source}`}>
          <strong>{t("heightFrom")}</strong>
          {localize(facts.source_text)}
        </p>
      )}
      <dl aria-label={t("facts")}>
        {rows.filter(([, value]) => value).map(([name, value]) => (
          <div key={name}>
            <dt>{t(name)}</dt>
            <dd>{value}</dd>
          </div>
        ))}
        <div>
          <dt>{t("collection")}</dt>
          <dd>{alone ? localize(work.collection_title) : <a href={`#/gallery?collection=${encodeURIComponent(work.collection)}`}>{localize(work.collection_title) || work.collection}</a>}</dd>
        </div>
      </dl>
    </header>
  );
}

/** The work's own size, and that of its maps where they are smaller: all is drawn of them, or only what is seen in depth. */
function Size({ work, facts }: { work: WorkTexts; facts: ViewerFacts | null }) {
  if (!facts) return <span class="size">{work.width} × {work.height} px</span>;
  const { width, height, spacing, unit } = facts;
  return (
    <>
      {unit === "mm" && <span class="size">{formatLength(width * spacing, unit)} × {formatLength(height * spacing, unit)}</span>}
      <span class="size">{work.width} × {work.height} px</span>
      {width < work.width && <span class="size reduced">{t(facts.tiles ? "inDepthAt" : "shownAt", { width, height })}</span>}
    </>
  );
}

/** Plain text whose web addresses are links. */
export function TextWithLinks({ text }: { text: string }) {
  const parts = text.split(/(https?:\/\/[^\s,;)）。，；]+)/);
  return <>{parts.map((part, k) => (k % 2 ? <a key={k} href={part} rel="noopener noreferrer" target="_blank">{part}</a> : part))}</>;
}
