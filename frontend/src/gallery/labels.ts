// Names of scripts, titles and messages as the gallery shows them.

import { common, localize } from "../i18n";

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
