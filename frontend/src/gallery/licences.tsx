// Licences in the reader's language, with a link to what they say.

import { language, localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { Bilingual } from "../types";

/** name; url: of the licence's text in the reader's language, null where there is none; rest: what was written after it. */
export type LicenceParts = { name: string; url: string | null; rest: string };

/** The service's licence of a work whose licence nobody stated. */
const NO_LICENCE = "none stated";

const TERMS: Record<string, Bilingual> = {
  BY: { zh: "姓名標示", en: "Attribution" },
  NC: { zh: "非商業性", en: "NonCommercial" },
  ND: { zh: "禁止改作", en: "NoDerivatives" },
  SA: { zh: "相同方式分享", en: "ShareAlike" },
};
const PLACES: Record<string, Bilingual> = {
  TW: { zh: "臺灣", en: "Taiwan" },
  HK: { zh: "香港", en: "Hong Kong" },
  CN: { zh: "中國大陸", en: "China Mainland" },
  IGO: { zh: "政府間組織", en: "IGO" },
};
/** Other licences by how people write them, and where their text is. */
const OTHERS: [pattern: RegExp, name: Bilingual, url: string | null][] = [
  [/^(?:SIL )?(?:OFL|Open Font License)[- ]?(?:v?1\.1)?/i, { zh: "SIL 開放字型授權 1.1", en: "SIL Open Font License 1.1" }, "https://openfontlicense.org"],
  [/^MIT(?: License)?\b/i, { zh: "MIT 授權條款", en: "MIT License" }, "https://opensource.org/license/mit"],
  [/^Apache[- ](?:License[, ]*)?(?:Version )?2\.0/i, { zh: "Apache 授權條款 2.0", en: "Apache License 2.0" }, "https://www.apache.org/licenses/LICENSE-2.0"],
  [/^(?:all rights reserved|版權所有|保留一切權利)/i, { zh: "保留一切權利", en: "all rights reserved" }, null],
];
/** What is written in one language about the works of the starter gallery. */
const PHRASES: [en: string, zh: string][] = [
  ["the font; a picture made with it is free", "指字型；用它作的圖不受限"],
  ["as declared by the author", "作者聲明"],
  ["copyright waived by the author", "作者放棄著作權"],
  ["shown unchanged", "原樣展示"],
  ["fonts, named with each work", "字型，見各件作品"],
  ["named with each work", "見各件作品"],
];

/** A source, a credit or a remark on a licence in Chinese, as far as its phrases are known. */
export function translated(text: string): string {
  if (language.value === "en") return text;
  return PHRASES.reduce((so, [en, zh]) => so.replaceAll(en, zh), text)
    .replace(/, (\S+) of Debian's (\S+) (\S+?),/, "（Debian 套件 $2 $3 的 $1），")
    .replace(/\bversion (\d)/g, "版本 $1");
}

export function licenceParts(licence: string): LicenceParts {
  const text = licence.trim();
  if (text === NO_LICENCE || !text) return { name: t("noLicence"), url: null, rest: "" };
  const deed = language.value === "zh" ? "deed.zh-hant" : "deed.en";
  const found = creativeCommons(text, deed) ?? publicDomain(text, deed) ?? other(text);
  if (!found) return { name: translated(text), url: null, rest: "" };
  const rest = text.slice(found.length).replace(/^[\s,;，；]+/, "").replace(/^[(（](.*)[)）]$/, "$1");
  return { name: found.name, url: found.url, rest: translated(rest) };
}

type Found = { name: string; url: string | null; length: number };

function creativeCommons(text: string, deed: string): Found | null {
  const address = /^https?:\/\/creativecommons\.org\/licenses\/([a-z-]+)\/(\d\.\d)(?:\/(tw|hk|cn|igo))?\S*/i.exec(text);
  const written = /^(?:CC|Creative Commons)[- ]?(BY(?:[- ](?:NC|ND|SA))*)(?:[- ]v?(\d\.\d))?(?:[- ](TW|HK|CN|IGO))?(?=$|[\s(（,;，；])/i.exec(text);
  const match = address ?? written;
  if (!match) return null;
  const terms = match[1]!.toUpperCase().split(/[- ]/);
  if (!terms.every((term) => TERMS[term])) return null;
  const [version, place] = [match[2], match[3]?.toUpperCase()];
  const name = [`CC ${terms.join("-")}${version ? ` ${version}` : ""}`, terms.map((term) => localize(TERMS[term]!)).join("-"), place && localize(PLACES[place]!)];
  const path = `${terms.join("-").toLowerCase()}/${version}/${place ? `${place.toLowerCase()}/` : ""}`;
  const url = version ? `https://creativecommons.org/licenses/${path}${deed}` : "https://creativecommons.org/share-your-work/cclicenses/";
  return { name: name.filter(Boolean).join(language.value === "zh" ? "　" : ", "), url, length: match[0].length };
}

function publicDomain(text: string, deed: string): Found | null {
  const zero = /^(?:CC[- ]?0(?:[- ]1\.0)?(?: Universal)?|https?:\/\/creativecommons\.org\/publicdomain\/zero\/1\.0\S*)/i.exec(text);
  if (zero) return { name: localize({ zh: "CC0 1.0　公眾領域貢獻宣告", en: "CC0 1.0, Public Domain Dedication" }), url: `https://creativecommons.org/publicdomain/zero/1.0/${deed}`, length: zero[0].length };
  const mark = /^(?:CC[- ])?(?:PDM|Public Domain Mark)(?:[- ]1\.0)?/i.exec(text);
  if (mark) return { name: localize({ zh: "公眾領域標章 1.0", en: "Public Domain Mark 1.0" }), url: `https://creativecommons.org/publicdomain/mark/1.0/${deed}`, length: mark[0].length };
  const free = /^(?:(?:in the )?public domain|公有領域|公共領域|公眾領域)/i.exec(text);
  return free && { name: localize({ zh: "公有領域", en: "public domain" }), url: null, length: free[0].length };
}

function other(text: string): Found | null {
  for (const [pattern, name, url] of OTHERS) {
    const match = pattern.exec(text);
    if (match) return { name: localize(name), url, length: match[0].length };
  }
  return null;
}

/** A licence in words, as in a list of facts. */
export function licenceName(licence: string): string {
  const { name, rest } = licenceParts(licence);
  return rest ? `${name}${localize({ zh: `（${rest}）`, en: ` (${rest})` })}` : name;
}

/** The licence as the value of an input: empty where none was stated. */
export const licenceField = (licence: string): string => (licence === NO_LICENCE ? "" : licence);

/** A licence with a link to what it says. */
export function Licence({ licence }: { licence: string }) {
  const { name, url, rest } = licenceParts(licence);
  return (
    <>
      {url ? <a href={url} rel="noopener noreferrer license" target="_blank">{name}</a> : name}
      {rest && localize({ zh: `（${rest}）`, en: ` (${rest})` })}
    </>
  );
}
