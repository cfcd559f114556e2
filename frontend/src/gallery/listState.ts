// What the gallery is narrowed by; it stands in the address, so that a choice can be sent to somebody.

import { signal } from "@preact/signals";
import type { Bilingual, WorkCard } from "../types";

export const FILTERS = ["script", "dynasty", "hand", "character", "collection"] as const;
export type FilterName = (typeof FILTERS)[number];
export type Filters = Partial<Record<FilterName | "q", string>>;

export function readFilters(query: URLSearchParams): Filters {
  const found: Filters = {};
  for (const name of [...FILTERS, "q"] as const) {
    const value = query.get(name)?.trim();
    if (value) found[name] = value;
  }
  return found;
}

export function writeFilters(filters: Filters): URLSearchParams {
  const query = new URLSearchParams();
  for (const name of [...FILTERS, "q"] as const) if (filters[name]) query.set(name, filters[name]);
  return query;
}

export const without = (filters: Filters, name: FilterName | "q"): Filters => ({ ...filters, [name]: undefined });

/** Names of dynasties as the last facets gave them: a card carries the key alone. */
export const dynasties = signal(new Map<string, Bilingual>());

type List = { key: string; items: WorkCard[]; total: number; scroll: number };

let lastStored: List | null = null;

export const lastList = (key: string): List | null => (lastStored?.key === key ? lastStored : null);
export const storeLastList = (list: List): void => void (lastStored = list);

/** After a change of the works the list is asked for anew. */
export const clearLastList = (): void => void (lastStored = null);
