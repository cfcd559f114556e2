// What the gallery is narrowed by; it stands in the address, so that a choice can be sent to somebody.

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
