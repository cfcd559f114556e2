// Two languages, chosen by the reader, remembered in the browser.

import { effect, signal } from "@preact/signals";
import type { Language, Text } from "../types";
import { common } from "./common";

const KEPT = "rumu.language";

export const language = signal<Language>(firstChoice());

effect(() => {
  document.documentElement.lang = language.value === "zh" ? "zh-Hant" : "en";
  try {
    localStorage.setItem(KEPT, language.value);
  } catch {
    // a browser that keeps nothing still shows the page
  }
});

/** The words in the reader's language. */
export const say = (text: Text | null | undefined): string => (text ? text[language.value] || text.en || text.zh : "");

/** A table of words becomes a function of their names: `const t = words(table); t("search")`. */
export const words =
  <K extends string>(table: Record<K, Text>) =>
  (name: K, values: Record<string, string | number> = {}): string =>
    say(table[name]).replace(/\{(\w+)\}/g, (_, key: string) => String(values[key] ?? ""));

export const t = words(common);

function firstChoice(): Language {
  try {
    const kept = localStorage.getItem(KEPT);
    if (kept === "zh" || kept === "en") return kept;
  } catch {
    // see above
  }
  return navigator.language.toLowerCase().startsWith("zh") ? "zh" : "en";
}
