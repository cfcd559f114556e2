// A practice sheet as it is asked for: from the address of the page, and as the address of the service.

import { query } from "../api";
import { SCRIPTS } from "../gallery/labels";

export const PAPERS = ["A4", "Letter"] as const;
export const PAPER_SIZES = { A4: { width: 210, height: 297 }, Letter: { width: 216, height: 279 } }; // millimetres
export const GRIDS = ["mi", "nine", "tian", "hui", "none"] as const;
export const HELPS = ["faint", "outlined", "beside", "shrinking", "none"] as const;
export const MASTERS = ["strokes", ...SCRIPTS] as const;
export const MAX_CHARACTERS = 200;
export const CELL = { min: 12, max: 80, usual: 28 };
export const MAX_TIMES = 60;
export const LONGEST_PUPIL = 24;

export type SheetRequest = {
  text: string;
  works: string[];
  master: (typeof MASTERS)[number];
  paper: (typeof PAPERS)[number];
  grid: (typeof GRIDS)[number];
  model: (typeof HELPS)[number];
  /** Side of a cell in millimetres. */
  cell: number;
  /** Cells for each character; 0 fills whole rows. */
  times: number;
  strokes: boolean;
  pupil: string;
  /** A class for each of whose pupils one is printed. */
  class: string;
};

export const USUAL: SheetRequest = {
  text: "", works: [], master: "strokes", paper: "A4", grid: "mi", model: "faint", cell: CELL.usual, times: 0, strokes: true, pupil: "", class: "",
};

const oneOf = <T extends string>(values: readonly T[], value: string | null, usual: T): T => values.find((one) => one === value) ?? usual;

function within(value: string | null, low: number, high: number, usual: number): number {
  const number = value === null || value === "" ? NaN : Number(value);
  return Number.isFinite(number) ? Math.min(high, Math.max(low, Math.round(number))) : usual;
}

/** The sheet that an address of the page asks for; what it does not say, or says wrongly, is as usual. */
export function readRequest(params: URLSearchParams): SheetRequest {
  return {
    text: params.get("text") ?? USUAL.text,
    works: params.getAll("works").filter(Boolean),
    master: oneOf(MASTERS, params.get("master"), USUAL.master),
    paper: oneOf(PAPERS, params.get("paper"), USUAL.paper),
    grid: oneOf(GRIDS, params.get("grid"), USUAL.grid),
    model: oneOf(HELPS, params.get("model"), USUAL.model),
    cell: within(params.get("cell"), CELL.min, CELL.max, USUAL.cell),
    times: within(params.get("times"), 0, MAX_TIMES, USUAL.times),
    strokes: params.get("strokes") !== "false",
    pupil: (params.get("pupil") ?? USUAL.pupil).slice(0, LONGEST_PUPIL),
    class: params.get("class") ?? USUAL.class,
  };
}

/** The query of a sheet: what is not as usual. */
export function requestQuery(asked: SheetRequest): URLSearchParams {
  const params = new URLSearchParams();
  for (const [name, value] of Object.entries(asked) as [keyof SheetRequest, string | number | boolean | string[]][])
    if (Array.isArray(value)) for (const one of value) params.append(name, one);
    else if (value !== USUAL[name]) params.set(name, String(value));
  return params;
}

/** The address of what the service makes of a sheet: its plan, a page as a picture, the PDF. */
export function sheetUrl(asked: SheetRequest, kind: "" | ".png" | ".pdf", number = 1): string {
  const { class: forClass, ...rest } = asked;
  const params = requestQuery({ ...rest, class: kind === ".pdf" ? forClass : "" });
  const page = kind === ".png" && number > 1 ? query({ number }).slice(1) : "";
  const all = [params.toString(), page].filter(Boolean).join("&");
  return `api/practice-sheet${kind}${all ? `?${all}` : ""}`;
}

/** Whether there is anything to print. */
export const isAsked = ({ text, works }: SheetRequest): boolean => text.trim() !== "" || works.length > 0;
