// The part of the address after the hash selects the page, so that every view has a link and any static server will do.

import { computed, signal } from "@preact/signals";

export type PageProps = { params: Record<string, string>; query: URLSearchParams };

const hash = signal(location.hash);
addEventListener("hashchange", () => (hash.value = location.hash));

export const route = computed(() => parseHash(hash.value));

export function parseHash(text: string): { path: string; query: URLSearchParams } {
  const [path = "", search = ""] = text.replace(/^#/, "").split("?", 2);
  return { path: path || "/", query: new URLSearchParams(search) };
}

export function matchPath(pattern: string, path: string): Record<string, string> | null {
  const wanted = pattern.split("/");
  const found = path.split("/");
  if (wanted.length !== found.length) return null;
  const params: Record<string, string> = {};
  for (const [k, part] of wanted.entries()) {
    const piece = found[k] ?? "";
    if (part.startsWith(":")) {
      if (!piece) return null;
      params[part.slice(1)] = decodeURIComponent(piece);
    } else if (part !== piece) return null;
  }
  return params;
}

export function navigate(path: string): void {
  location.hash = path;
}

/** Change the query of the present page without a new entry in the history: a view that is being turned. */
export function replaceQuery(query: URLSearchParams): void {
  const text = query.toString().replaceAll("%2C", ",");
  history.replaceState(null, "", `#${route.value.path}${text ? `?${text}` : ""}`);
  hash.value = location.hash; // replaceState tells nobody
}
