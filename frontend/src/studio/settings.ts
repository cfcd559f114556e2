// How somebody likes to write, and what they have written so far; both stay in this browser.

import { GRIDS } from "./grids";
import { parseStrokes, serializeStrokes, type Stroke } from "./ink/strokes";
import type { Grid } from "../types";

export type WritingSettings = { size: number; ink: number; grid: Grid; ghost: number; auto: boolean };
export const DEFAULT_SETTINGS: WritingSettings = { size: 0.042, ink: 0.5, grid: "mi", ghost: 0.35, auto: false };
export const BRUSH_SIZES = { min: 0.012, max: 0.09 }; // radius of the pressed brush, of the cell

const SETTINGS = "rumu.writing";
const RECENT = "rumu.recent";
const MAX_RECENT = 12;

export function loadSettings(): WritingSettings {
  const stored = read(localStorage, SETTINGS) as Partial<WritingSettings> | null;
  const number = (value: unknown, low: number, high: number, otherwise: number) =>
    typeof value === "number" && value >= low && value <= high ? value : otherwise;
  return {
    size: number(stored?.size, BRUSH_SIZES.min, BRUSH_SIZES.max, DEFAULT_SETTINGS.size),
    ink: number(stored?.ink, 0, 1, DEFAULT_SETTINGS.ink),
    grid: GRIDS.find((grid) => grid === stored?.grid) ?? DEFAULT_SETTINGS.grid,
    ghost: number(stored?.ghost, 0, 1, DEFAULT_SETTINGS.ghost),
    auto: stored?.auto === true,
  };
}

export const saveSettings = (settings: WritingSettings): void => write(localStorage, SETTINGS, settings);

/** The unfinished sheet of a work outlives a login or a look at another page. */
export const loadDraft = (work: string): Stroke[] => parseStrokes(read(sessionStorage, `rumu.draft.${work}`));
export const saveDraft = (work: string, strokes: readonly Stroke[]): void =>
  write(sessionStorage, `rumu.draft.${work}`, serializeStrokes(strokes));

export function recentWorks(): string[] {
  const stored = read(localStorage, RECENT);
  return Array.isArray(stored) ? stored.filter((id): id is string => typeof id === "string") : [];
}
export const addRecentWork = (work: string): void =>
  write(localStorage, RECENT, [work, ...recentWorks().filter((id) => id !== work)].slice(0, MAX_RECENT));

function read(storage: Storage, key: string): unknown {
  try {
    return JSON.parse(storage.getItem(key) ?? "null");
  } catch {
    return null; // a browser that keeps nothing, or something else under this name
  }
}

function write(storage: Storage, key: string, value: unknown): void {
  try {
    storage.setItem(key, JSON.stringify(value));
  } catch {
    // writing goes on without
  }
}
