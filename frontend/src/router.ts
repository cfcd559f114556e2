// The page is chosen by what stands after the hash, so that every view has a link and any static server will do.

import { computed, signal } from "@preact/signals";
import type { ComponentType } from "preact";

export type PageProps = { params: Record<string, string>; query: URLSearchParams };
type Load = () => Promise<{ default: ComponentType<PageProps> }>;

/** Path patterns, `:name` for a part; the first that fits is shown. Each page is loaded when it is first asked for. */
export const routes: [string, Load][] = [
  ["/", () => import("./gallery/Browse")],
  ["/works/:id", () => import("./gallery/WorkPage")],
  ["/collections", () => import("./gallery/Collections")],
  ["/tours", () => import("./gallery/Tours")],
  ["/tours/:id", () => import("./gallery/TourPage")],
  ["/add", () => import("./gallery/AddWork")],
  ["/studio", () => import("./studio/Choose")],
  ["/studio/:id", () => import("./studio/Write")],
  ["/attempts/:id", () => import("./studio/AttemptPage")],
  ["/practice", () => import("./studio/Practice")],
  ["/classes", () => import("./studio/Classes")],
  ["/classes/:id", () => import("./studio/ClassPage")],
  ["/tasks/:id", () => import("./studio/TaskPage")],
  ["/judge", () => import("./studio/Judge")],
  ["/login", () => import("./account/Login")],
  ["/join/:token", () => import("./account/Join")],
  ["/people", () => import("./account/People")],
  ["/account", () => import("./account/Password")],
];

const hash = signal(location.hash);
addEventListener("hashchange", () => (hash.value = location.hash));

export const place = computed(() => readHash(hash.value));

export function readHash(text: string): { path: string; query: URLSearchParams } {
  const [path = "", search = ""] = text.replace(/^#/, "").split("?", 2);
  return { path: path || "/", query: new URLSearchParams(search) };
}

export function match(pattern: string, path: string): Record<string, string> | null {
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

export function go(path: string): void {
  location.hash = path;
}

/** Change the query of the present page without a new entry in the history: a view that is being turned. */
export function rewrite(query: URLSearchParams): void {
  const text = query.toString().replaceAll("%2C", ",");
  history.replaceState(null, "", `#${place.value.path}${text ? `?${text}` : ""}`);
  hash.value = location.hash; // replaceState tells nobody
}
