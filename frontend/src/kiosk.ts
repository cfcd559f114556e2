// A screen in an exhibition: without menus and links that lead away, it goes back to its page when nobody touches it, and
// then shows the tour of that page by itself.

import { effect, signal } from "@preact/signals";
import { navigate, route } from "./router";

/** path: the page to go back to. seconds: how long nobody touches the screen before it does. */
export type Kiosk = { path: string; seconds: number };

const KEY = "kiosk";
const SHORTEST = 10;
const USUAL = 90;
const LONGEST = 3600;
const SIGNS = ["pointerdown", "keydown", "wheel", "touchstart"] as const;
/** Pages that a visitor of an exhibition may see. */
const SHOWN = /^\/(collections\/[^/]+|works\/[^/]+|tours\/[^/]+|characters\/[^/]+)$/;

export const kiosk = signal<Kiosk | null>(stored());

function stored(): Kiosk | null {
  try {
    const value = JSON.parse(sessionStorage.getItem(KEY) ?? "null") as Kiosk | null;
    return value && typeof value.path === "string" ? { path: value.path, seconds: secondsOf(String(value.seconds)) } : null;
  } catch {
    return null;
  }
}

/** Seconds as they stand in an address; what is no number of seconds is the usual time. */
export function secondsOf(text: string): number {
  const seconds = Number(text);
  return text.trim() && Number.isFinite(seconds) ? Math.min(Math.max(seconds, SHORTEST), LONGEST) : USUAL;
}

/** Whether a link leads to something that visitors may see. */
export const isShown = (href: string): boolean => href.startsWith("#") && SHOWN.test(href.slice(1).split("?")[0]!);

export function enterKiosk(next: Kiosk): void {
  sessionStorage.setItem(KEY, JSON.stringify(next));
  kiosk.value = next;
}

export function leaveKiosk(): void {
  sessionStorage.removeItem(KEY);
  kiosk.value = null;
}

/** Begin to watch the screen; onIdle: what happens on the page of the exhibition when nobody comes. Returns what ends it. */
export function watchScreen(onIdle: () => void): () => void {
  let timer = 0;
  const arrive = () => {
    clearTimeout(timer);
    const now = kiosk.value;
    if (!now) return;
    timer = window.setTimeout(() => {
      if (route.value.query.has("play")) arrive(); // the tour that plays by itself
      else if (route.value.path !== now.path) navigate(now.path);
      else onIdle();
    }, now.seconds * 1000);
  };
  const stay = (event: MouseEvent) => {
    const link = event.target instanceof Element ? event.target.closest("a") : null;
    if (!kiosk.value || !link || isShown(link.getAttribute("href") ?? "")) return;
    event.preventDefault();
    event.stopPropagation();
  };
  const turnMenuOff = (event: Event) => kiosk.value && event.preventDefault();
  for (const name of SIGNS) addEventListener(name, arrive, { passive: true });
  document.addEventListener("click", stay, true);
  document.addEventListener("contextmenu", turnMenuOff);
  const follow = effect(() => {
    void route.value.path; // a page that has just opened is looked at
    document.documentElement.toggleAttribute("data-kiosk", kiosk.value !== null);
    arrive();
  });
  return () => {
    follow();
    clearTimeout(timer);
    for (const name of SIGNS) removeEventListener(name, arrive);
    document.removeEventListener("click", stay, true);
    document.removeEventListener("contextmenu", turnMenuOff);
  };
}
