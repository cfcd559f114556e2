// What a museum says of a work in its IIIF manifest, in the reader's language where it has it.

import type { ComponentChildren } from "preact";
import { language } from "../i18n";
import { t } from "../i18n/whole";
import type { Languages, MuseumRecord } from "../types";
import { TextWithLinks } from "./WorkFacts";

const CHINESE = /^(zh|lzh)/i;
const ENGLISH = /^en/i;

/** The texts of the reader's language; else those without one, English, or whatever comes first. */
export function textsFor(texts: Languages): { lang: string; texts: string[] } | null {
  const entries = Object.entries(texts).filter(([, some]) => some.length);
  const wanted = language.value === "zh" ? [CHINESE, /^ja/i, /^none$/, ENGLISH] : [ENGLISH, /^none$/];
  const found = wanted.map((form) => entries.find(([name]) => form.test(name))).find(Boolean) ?? entries[0];
  return found ? { lang: found[0] === "none" ? "" : found[0], texts: found[1] } : null;
}

export function MuseumFacts({ record }: { record: MuseumRecord | null }) {
  if (!record) return null;
  const { statement } = record;
  return (
    <details class="museum facts" open>
      <summary>{t("record")}</summary>
      <dl>
        {record.provider.length > 0 && <Row name={t("provider")}>{record.provider.map((one, k) => <Words key={k} of={one} />)}</Row>}
        {statement && <Row name={<Words of={statement.label} plain />}><Words of={statement.value} /></Row>}
        {record.rights && <Row name={t("rights")}><TextWithLinks text={record.rights} /></Row>}
        {Object.keys(record.canvas_label).length > 0 && <Row name={t("leaf")}><Words of={record.canvas_label} /></Row>}
        {record.metadata.map((fact, k) => <Row key={k} name={<Words of={fact.label} plain />}><Words of={fact.value} /></Row>)}
        {isWeb(record.homepage) && <Row name={t("homepage")}><a href={record.homepage} rel="noopener noreferrer" target="_blank">{new URL(record.homepage).hostname}</a></Row>}
        {isWeb(record.manifest) && <Row name={t("manifest")}><a href={record.manifest} rel="noopener noreferrer" target="_blank">{new URL(record.manifest).hostname}</a></Row>}
      </dl>
    </details>
  );
}

const Row = ({ name, children }: { name: ComponentChildren; children: ComponentChildren }) => (
  <div>
    <dt>{name}</dt>
    <dd>{children}</dd>
  </div>
);

function Words({ of, plain = false }: { of: Languages; plain?: boolean }) {
  const found = textsFor(of);
  if (!found) return null;
  const lang = found.lang || undefined;
  return plain ? <span lang={lang}>{found.texts.join("; ")}</span> : <>{found.texts.map((text) => <span key={text} class="size" lang={lang}><TextWithLinks text={text} /></span>)}</>;
}

/** Whether an address may be a link: a manifest may say anything, such as javascript:. */
function isWeb(address: string): boolean {
  try {
    return /^https?:$/.test(new URL(address).protocol);
  } catch {
    return false;
  }
}
