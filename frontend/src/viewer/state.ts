// The state of a view in a few values: what is shown, from where, under which light. A permalink consists of these.

export const MODES = ["sheet", "surface", "mesh", "heights", "contours"] as const;
export type Mode = (typeof MODES)[number];
export const LENSES = ["none", "magnify", "picture", "heights", "normals"] as const;
export type Lens = (typeof LENSES)[number];
/** How the sheet is lit: a warm lamp with some sheen, Lambert's law alone, or without colours, as clay. */
export const LOOKS = ["lamp", "exact", "clay"] as const;
export type Look = (typeof LOOKS)[number];
export type SheetLine = [number, number, number, number];
/** Position of the camera, then its target; the longer side of the sheet is 1, x right, y up, z towards the viewer. */
export type Camera = [number, number, number, number, number, number];

export type ViewState = {
  mode: Mode;
  /** Degrees counter-clockwise from +x: 0 right, 90 top. */
  tilt: number;
  /** Degrees from +z: 0 straight above the sheet, 90 along it. */
  slant: number;
  /** Factor on the heights; 1 is true to scale. */
  exaggeration: number;
  /** null: the default camera of the mode, which sees the whole sheet. */
  camera: Camera | null;
  /** A line over the sheet, x0 y0 x1 y1 as fractions, origin top left. */
  section: SheetLine | null;
  ruler: SheetLine | null;
  lens: Lens;
  look: Look;
  /** Mix the three photographs, where there are three, instead of shading the normals. */
  mixture: boolean;
};

export const DEFAULT_VIEW: ViewState = {
  mode: "sheet",
  tilt: 135,
  slant: 45,
  exaggeration: 1,
  camera: null,
  section: null,
  ruler: null,
  lens: "none",
  look: "lamp",
  mixture: false,
};

/** Highest exaggeration that the slider offers. */
export const MAX_EXAGGERATION = 10;
/** Degrees; a lower lamp would light only edges. */
const MAX_SLANT = 88;

/** A valid state from any numbers: angles are wrapped, other values clamped. */
export function normalizeView(state: ViewState): ViewState {
  return {
    ...state,
    tilt: ((state.tilt % 360) + 360) % 360,
    slant: clamp(state.slant, 0, MAX_SLANT),
    exaggeration: clamp(state.exaggeration, 0, MAX_EXAGGERATION),
    section: state.section && (state.section.map((v) => clamp(v, 0, 1)) as SheetLine),
    ruler: state.ruler && (state.ruler.map((v) => clamp(v, 0, 1)) as SheetLine),
  };
}

/** Only what differs from the default view, so that links stay short. */
export function stateToQuery(state: ViewState): URLSearchParams {
  const query = new URLSearchParams();
  if (state.mode !== DEFAULT_VIEW.mode) query.set("mode", state.mode);
  if (state.tilt !== DEFAULT_VIEW.tilt) query.set("tilt", short(state.tilt, 1));
  if (state.slant !== DEFAULT_VIEW.slant) query.set("slant", short(state.slant, 1));
  if (state.exaggeration !== DEFAULT_VIEW.exaggeration) query.set("ex", short(state.exaggeration, 2));
  if (state.camera) query.set("cam", state.camera.map((v) => short(v, 5)).join(","));
  if (state.section) query.set("sec", state.section.map((v) => short(v, 3)).join(","));
  if (state.ruler) query.set("rule", state.ruler.map((v) => short(v, 3)).join(","));
  if (state.lens !== DEFAULT_VIEW.lens) query.set("lens", state.lens);
  if (state.look !== DEFAULT_VIEW.look) query.set("look", state.look);
  if (state.mixture) query.set("lamps", "3");
  return query;
}

/** Values that cannot be read are those of the default view, so that a damaged link still opens. */
export function stateFromQuery(query: URLSearchParams): ViewState {
  return normalizeView({
    mode: oneOf(MODES, query.get("mode"), DEFAULT_VIEW.mode),
    tilt: number(query.get("tilt"), DEFAULT_VIEW.tilt),
    slant: number(query.get("slant"), DEFAULT_VIEW.slant),
    exaggeration: number(query.get("ex"), DEFAULT_VIEW.exaggeration),
    camera: numbers(query.get("cam"), 6) as Camera | null,
    section: numbers(query.get("sec"), 4) as SheetLine | null,
    ruler: numbers(query.get("rule"), 4) as SheetLine | null,
    lens: oneOf(LENSES, query.get("lens"), DEFAULT_VIEW.lens),
    look: oneOf(LOOKS, query.get("look"), DEFAULT_VIEW.look),
    mixture: query.get("lamps") === "3",
  });
}

export function clamp(value: number, low: number, high: number): number {
  return Math.min(high, Math.max(low, value));
}

const short = (value: number, digits: number): string => String(Number(value.toFixed(digits)));

function oneOf<T extends string>(names: readonly T[], text: string | null, otherwise: T): T {
  return names.find((name) => name === text) ?? otherwise;
}

function number(text: string | null, otherwise: number): number {
  if (text === null || text.trim() === "") return otherwise;
  const value = Number(text);
  return Number.isFinite(value) ? value : otherwise;
}

function numbers(text: string | null, count: number): number[] | null {
  const values = (text ?? "").split(",").map(Number);
  return text && values.length === count && values.every(Number.isFinite) ? values : null;
}

/** Direction of a lamp held over (x, y): straight above in the middle, along the sheet at the edge of the largest circle. Degrees. */
export function lightAt(x: number, y: number, size: { width: number; height: number }): { tilt: number; slant: number } {
  const radius = Math.min(size.width, size.height) / 2;
  const [right, up] = [(x - size.width / 2) / radius, (size.height / 2 - y) / radius];
  const away = Math.min(Math.hypot(right, up), 1);
  return {
    tilt: ((Math.atan2(up, right) * 180) / Math.PI + 360) % 360,
    slant: Math.min((Math.asin(away) * 180) / Math.PI, MAX_SLANT),
  };
}
