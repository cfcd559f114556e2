// Texts in two languages; the reader chooses one, and the browser remembers it.

import { effect, signal } from "@preact/signals";
import type { Bilingual, Language } from "../types";
import { commonTexts } from "./common";

const STORAGE_KEY = "rumu.language";

export const language = signal<Language>(initialLanguage());

effect(() => {
  document.documentElement.lang = language.value === "zh" ? "zh-Hant" : "en";
  try {
    localStorage.setItem(STORAGE_KEY, language.value);
  } catch {
    // without storage the page works, and forgets the language
  }
});

/** The text in the reader's language, or in the other one where it is missing. */
export const localize = (text: Bilingual | null | undefined): string => (text ? text[language.value] || text.en || text.zh : "");

/** A function from the keys of a table to its texts: `const t = translator(table); t("search")`. `{name}` is filled from `values`. */
export const translator =
  <K extends string>(table: Record<K, Bilingual>) =>
  (key: K, values: Record<string, string | number> = {}): string =>
    localize(table[key]).replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? ""));

/** Texts that several parts use. Each part has a table of its own, whose function is called `t`. */
export const common = translator(commonTexts);

function initialLanguage(): Language {
  try {
    const stored = localStorage.getItem(STORAGE_KEY);
    if (stored === "zh" || stored === "en") return stored;
  } catch {
    // as above
  }
  return navigator.language.toLowerCase().startsWith("zh") ? "zh" : "en";
}

const locale = () => (language.value === "zh" ? "zh-Hant-TW" : "en-GB");

/** Times of the service (ISO 8601) in the reader's language and time zone. */
export const formatDay = (time: string): string => new Date(time).toLocaleDateString(locale(), { month: "short", day: "numeric" });
export const formatTime = (time: string): string => new Date(time).toLocaleTimeString(locale(), { hour: "2-digit", minute: "2-digit" });
export const formatDate = (time: string): string => new Date(time).toLocaleDateString(locale(), { year: "numeric", month: "long", day: "numeric" });
export const formatDateTime = (time: string): string =>
  new Date(time).toLocaleString(locale(), { year: "numeric", month: "short", day: "numeric", hour: "2-digit", minute: "2-digit" });
