// How somebody likes to write, and what they have written so far; both stay in this browser.

import { GRIDS } from "./ink/grids";
import { strokesOf, sheetOf, type Stroke } from "./ink/stroke";
import type { Grid } from "../types";

export type WritingSettings = { size: number; ink: number; grid: Grid; ghost: number; auto: boolean };
export const USUAL: WritingSettings = { size: 0.042, ink: 0.5, grid: "mi", ghost: 0.35, auto: false };
export const SIZES = { least: 0.012, most: 0.09 }; // radius of the pressed brush, of the cell

const SETTINGS = "rumu.writing";
const RECENT = "rumu.recent";
const RECENT_KEPT = 12;

export function keptSettings(): WritingSettings {
  const kept = read(localStorage, SETTINGS) as Partial<WritingSettings> | null;
  const number = (value: unknown, low: number, high: number, usual: number) =>
    typeof value === "number" && value >= low && value <= high ? value : usual;
  return {
    size: number(kept?.size, SIZES.least, SIZES.most, USUAL.size),
    ink: number(kept?.ink, 0, 1, USUAL.ink),
    grid: GRIDS.find((grid) => grid === kept?.grid) ?? USUAL.grid,
    ghost: number(kept?.ghost, 0, 1, USUAL.ghost),
    auto: kept?.auto === true,
  };
}

export const keepSettings = (settings: WritingSettings): void => write(localStorage, SETTINGS, settings);

/** The unfinished sheet of a work outlives a login or a look at another page. */
export const draftOf = (work: string): Stroke[] => strokesOf(read(sessionStorage, `rumu.draft.${work}`));
export const keepDraft = (work: string, strokes: readonly Stroke[]): void =>
  write(sessionStorage, `rumu.draft.${work}`, sheetOf(strokes));

export function recentWorks(): string[] {
  const kept = read(localStorage, RECENT);
  return Array.isArray(kept) ? kept.filter((id): id is string => typeof id === "string") : [];
}
export const keepRecent = (work: string): void =>
  write(localStorage, RECENT, [work, ...recentWorks().filter((id) => id !== work)].slice(0, RECENT_KEPT));

function read(place: Storage, key: string): unknown {
  try {
    return JSON.parse(place.getItem(key) ?? "null");
  } catch {
    return null; // a browser that keeps nothing, or something else under this name
  }
}

function write(place: Storage, key: string, value: unknown): void {
  try {
    place.setItem(key, JSON.stringify(value));
  } catch {
    // writing goes on without
  }
}
