// The part of the address after the hash selects the page, so that every view has a link and a static server suffices.

import { computed, signal } from "@preact/signals";

export type PageProps = { params: Record<string, string>; query: URLSearchParams };

const hash = signal(location.hash);
addEventListener("hashchange", () => (hash.value = location.hash));

export const route = computed(() => parseHash(hash.value));

function parseHash(text: string): { path: string; query: URLSearchParams } {
  const [path = "", search = ""] = text.replace(/^#/, "").split("?", 2);
  return { path: path || "/", query: new URLSearchParams(search) };
}

/** The parameters of a path that matches the pattern, else null. */
export function matchPath(pattern: string, path: string): Record<string, string> | null {
  const expected = pattern.split("/");
  const actual = path.split("/");
  if (expected.length !== actual.length) return null;
  const params: Record<string, string> = {};
  for (const [k, part] of expected.entries()) {
    const piece = actual[k] ?? "";
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

/** Changes the query of the current page without a new history entry, as while a view is being turned. */
export function replaceQuery(query: URLSearchParams): void {
  const text = query.toString().replaceAll("%2C", ",");
  history.replaceState(null, "", `#${route.value.path}${text ? `?${text}` : ""}`);
  hash.value = location.hash; // replaceState fires no event
}
