// What the service says of photographs of sheets, and what a page tells of it.

import { post } from "../api";
import type { Bilingual } from "../types";

export type SheetCell = {
  row: number;
  column: number;
  character: string;
  /** Corners in the photograph, in its pixels. */
  polygon: [number, number][];
  score: number | null;
  level_text: Bilingual | null;
  refused: (Bilingual & { code: string }) | null;
  /** The worst remark, or what is good. */
  told: Bilingual | null;
  is_fault: boolean;
  attempt: string | null;
  picture: string | null;
};
export type SheetPhoto = {
  photo: string;
  refused: (Bilingual & { code: string }) | null;
  sheet: string | null;
  number: number | null;
  count: number | null;
  pupil: string;
  person: { id: string; name: string } | null;
  is_of_another: boolean;
  empty: number;
  mean: number | null;
  cells: SheetCell[];
};
export type SheetUpload = {
  id: string;
  created: string;
  person: { id: string; name: string };
  school_class: { id: string; name: string } | null;
  photos: SheetPhoto[];
  table: string | null;
  teacher: string | null;
  archive: string | null;
};
export type SheetSummary = { id: string; created: string; photos: number; unread: number; cells: number; mean: number | null; characters: string };

/** The cells of a sheet in its rows, each from the left. */
export function rowsOf(cells: readonly SheetCell[]): SheetCell[][] {
  const rows = new Map<number, SheetCell[]>();
  for (const cell of [...cells].sort((a, b) => a.row - b.row || a.column - b.column)) rows.set(cell.row, [...(rows.get(cell.row) ?? []), cell]);
  return [...rows.values()];
}

/** The cell with the lowest mark; null where none has one. */
export const lowestOf = (cells: readonly SheetCell[]): SheetCell | null =>
  cells.reduce<SheetCell | null>((low, cell) => (cell.score !== null && (low === null || cell.score < low.score!) ? cell : low), null);

/** The sentence that a cell shows: why it has no mark, else its worst remark or what is good of it. */
export const sentenceOf = (cell: SheetCell): Bilingual | null => cell.refused ?? cell.told;

/** Sends the photograph of a sheet; the id by which its cells are seen. */
export async function sendSheet(file: File): Promise<string> {
  const form = new FormData();
  form.set("picture", file, file.name);
  return (await post<SheetUpload>("api/sheets", form)).id;
}
