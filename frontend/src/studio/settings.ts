// What the browser stores for writing: settings, unfinished drafts, and the works last opened.

import { GRIDS } from "./grids";
import { parseStrokes, serializeStrokes, type Stroke } from "./ink/strokes";
import type { Grid } from "../types";

/** size: radius of the brush, fraction of the cell. ink: 0 dry to 1 wet. ghost: opacity of the master to trace. auto: mark without asking. */
export type WritingSettings = { size: number; ink: number; grid: Grid; ghost: number; auto: boolean };
const DEFAULT_SETTINGS: WritingSettings = { size: 0.042, ink: 0.5, grid: "mi", ghost: 0.35, auto: false };
export const BRUSH_SIZES = { min: 0.012, max: 0.09 }; // radius of the fully pressed brush, as a fraction of the cell

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

/** The unfinished strokes for a work, which survive a login or a visit to another page. */
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
    return null; // no storage, or no JSON under this key
  }
}

function write(storage: Storage, key: string, value: unknown): void {
  try {
    storage.setItem(key, JSON.stringify(value));
  } catch {
    // writing works without storage
  }
}
