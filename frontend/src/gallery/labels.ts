// Names of scripts, titles and messages as the gallery shows them.

import { common, localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { Meaning, Understood } from "../types";

export const SCRIPTS = ["seal", "clerical", "regular", "running", "cursive"] as const;
/** 楷書 or Regular; anything but the five scripts stays as it is. */
export function scriptName(script: string): string {
  const known = SCRIPTS.find((name) => name === script);
  return known ? common(known) : script;
}

const NUMBER = /^\s*(?:\d+|[一二三四五六七八九十百]+)\s*[.、．:：)）]\s*(?=\S)/u;

/** A title for a numbered list, without a number of its own: 「1. The upright」 and 「一、豎」 lose it, 「一個水」 does not. */
export const withoutNumber = (title: string): string => title.replace(NUMBER, "");

/** A message in the reader's language; the service sends each step of a job in both, Chinese first: 「解開 Unpacking」. */
export function messageInOneLanguage(message: string): string {
  const both = /^(\P{ASCII}+) (\p{ASCII}+)$/u.exec(message);
  return both ? localize({ zh: both[1]!, en: both[2]! }) : message;
}

const MEANINGS = {
  character: "asCharacter", form: "asForm", reading: "asReading", other_reading: "asOtherReading", hand: "asHand",
  title: "asTitle", script: "asScript", dynasty: "asDynasty", other: "asOther",
} as const satisfies Record<Meaning, string>;

/** Each word of a search once, with all that it was taken for, the nearest first: 「作為字，2 件」. */
export function wordsUnderstood(understood: Understood[]): { word: string; meanings: string[] }[] {
  const words = new Map<string, string[]>();
  for (const { word, meaning, works } of understood)
    words.set(word, [...(words.get(word) ?? []), t("meaningOf", { meaning: t(MEANINGS[meaning]), n: works.toLocaleString() })]);
  return [...words].map(([word, meanings]) => ({ word, meanings }));
}
