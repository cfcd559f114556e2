// The state of the gallery's list: filters, which are part of the address so that they can be shared as a link, the names
// of dynasties, and the list as it was last seen.

import { signal } from "@preact/signals";
import type { Bilingual, Understood, WorkCard } from "../types";

export const FILTERS = ["script", "dynasty", "hand", "character", "collection"] as const;
export type FilterName = (typeof FILTERS)[number];
export type Filters = Partial<Record<FilterName | "q", string>>;

export function readFilters(query: URLSearchParams): Filters {
  const filters: Filters = {};
  for (const name of [...FILTERS, "q"] as const) {
    const value = query.get(name)?.trim();
    if (value) filters[name] = value;
  }
  return filters;
}

export function writeFilters(filters: Filters): URLSearchParams {
  const query = new URLSearchParams();
  for (const name of [...FILTERS, "q"] as const) if (filters[name]) query.set(name, filters[name]);
  return query;
}

export const without = (filters: Filters, name: FilterName | "q"): Filters => ({ ...filters, [name]: undefined });

/** Names of dynasties from the facets last loaded; a work itself has only the key. */
export const dynasties = signal(new Map<string, Bilingual>());

type List = { key: string; items: WorkCard[]; total: number; understood: Understood[]; scroll: number };

/** The list last shown, so that coming back from a work restores it with its scroll position. */
let lastStored: List | null = null;

export const lastList = (key: string): List | null => (lastStored?.key === key ? lastStored : null);
export const storeLastList = (list: List): void => void (lastStored = list);

/** To be called after any change of works, so that the list is loaded again. */
export const clearLastList = (): void => void (lastStored = null);
