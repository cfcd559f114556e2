// The service's JSON, as described in docs/service.md and /api/openapi.json.

export type Language = "zh" | "en";
export type Bilingual = { zh: string; en: string };
export type Role = "owner" | "teacher" | "pupil";
export type HeightSource = "photometric" | "inflation" | "density";

export type Person = { id: string; name: string; role: Role; language: Language };
export type SessionFacts = { person: Person | null; csrf: string; owner_exists: boolean; version: string };

export type WorkCard = {
  id: string;
  title: Bilingual;
  character: string;
  script: string;
  hand: Bilingual;
  dynasty: string;
  period: Bilingual;
  collection: string;
  /** The page that a character stands on. */
  parent: string | null;
  kind: "image" | "capture";
  height_source: HeightSource;
  width: number;
  height: number;
  thumb: string;
  thumb_normals: string;
};

/** The home page. cover: with files small enough for a phone. */
/** A work that a lamp lights: pictures small enough for a phone. */
export type CoverWork = WorkCard & { picture: string; normals: string };
export type Home = { cover: CoverWork | null; chosen: boolean; works: number };

/** works: how many, without the characters within pages. */
export type Collection = { id: string; title: Bilingual; note: Bilingual; source: string; licence: string; works: number };
export type Exhibition = Collection & { cover: CoverWork | null; chosen: boolean; tour: { id: string; title: Bilingual } | null };

/** A character's strokes in the order of writing, in a square of side 1, y down. */
export type CharacterStrokes = {
  character: string;
  structure: string | null;
  strokes: { name: Bilingual; path: string; centre_line: [number, number][] }[];
};

/** Where a character stands on its page. polygon: fractions of the page, origin top left; register, column, row: from 0. */
export type Place = {
  polygon: [number, number][];
  register: number;
  column: number;
  row: number;
  small: number | null;
  certainty: number;
  direction: "vertical" | "horizontal";
};
export type CharacterWithin = { id: string; character: string; place: Place };

/** Texts by language, as IIIF has them. */
export type Languages = Record<string, string[]>;
/** What a museum says of a work in its IIIF manifest. */
export type MuseumRecord = {
  label: Languages;
  canvas_label: Languages;
  metadata: { label: Languages; value: Languages }[];
  statement: { label: Languages; value: Languages } | null;
  provider: Languages[];
  rights: string;
  manifest: string;
  canvas: string;
  homepage: string;
};

export type Annotation = { id: string; x: number; y: number; title: Bilingual; text: Bilingual };

export type Work = WorkCard & {
  material: Bilingual;
  source: string;
  licence: string;
  attribution: string;
  collection_title: Bilingual;
  files: Record<"picture" | "albedo" | "normals" | "normals16" | "height" | "glb" | "stl" | "ply" | "manifest", string>;
  annotations: Annotation[];
  spacing: number | null;
  previous: string | null;
  next: string | null;
  /** How many characters stand on it, where it is a page. */
  characters: number;
  text: string;
  within: { id: string; title: Bilingual; place: Place; same: string[] } | null;
  record: MuseumRecord | null;
};

export type Facet = { value: string; zh: string; en: string; count: number };
export type Facets = Record<"script" | "dynasty" | "hand" | "character" | "collection", Facet[]>;
export type Page<T> = { total: number; items: T[] };

/** What a word of a search may be, the nearest first. */
export type Meaning = "character" | "form" | "reading" | "other_reading" | "hand" | "title" | "script" | "dynasty" | "other";
/** What a word was taken for. works: how many of those found have this as its best meaning. */
export type Understood = { word: string; meaning: Meaning; works: number };
export type FoundWork = WorkCard & { characters: number };
export type FoundWorks = Page<FoundWork> & { understood: Understood[] };

/** The viewer's data for a surface, of a work or of a learner's copy. */
export type ViewerFacts = {
  width: number;
  height: number;
  unit: "mm" | "px";
  spacing: number;
  source: HeightSource;
  source_text: Bilingual;
  /** Raw float32, little endian, row by row from the top, in `unit`. */
  heights: { url: string; width: number; height: number; min: number; max: number };
  normals: string;
  albedo: string;
  picture: string;
  mask: string;
  three_lamps: null | { a: string; b: string; c: string; slant: number };
  glb: string;
  /** Of a work larger than its maps: its image services, and the version of their tiles. */
  tiles?: TileServices | null;
};

/** Image services by the maps that they show; a map without one is missing or null. version: empty where it is not known. */
export type TileServices = { [map in TiledMap | "heights"]?: string | null } & { version: string };
export type TiledMap = "albedo" | "normals" | "picture" | "lamp-a" | "lamp-b" | "lamp-c";

export type TourStep = { work: string; view: string; title: Bilingual; text: Bilingual };
export type Tour = { id: string; title: Bilingual; steps: TourStep[] };

export type Part = { name: string; zh: string; en: string; score: number; meaning: Bilingual };
export type Remark = {
  kind: string;
  /** The kind as a text for readers. */
  name?: Bilingual;
  zh: string;
  en: string;
  severity: number;
  size: number;
  unit: string;
  region: [number, number, number, number] | null;
  outline: [number, number][][];
  /** The strokes it speaks of in the master's cell; absent in marks of older versions. */
  master_outline?: [number, number][][];
  /** Number of the stroke in the order of writing, from 1. */
  stroke?: number | null;
};

export type Mark = {
  score: number | null;
  level: "excellent" | "good" | "medium" | "bad" | null;
  level_text: Bilingual | null;
  /** The lowest score of each level; anything lower is bad. */
  cuts?: { excellent: number; good: number; medium: number } | null;
  /** The share of learners' copies that get a lower score, in per cent; absent where it is not known. */
  percentile?: number | null;
  interval: [number, number] | null;
  interval_note: Bilingual | null;
  /** What was taken off for how the whole stands in its picture; absent in marks of older versions. */
  deduction_note?: Bilingual | null;
  parts: Part[];
  /** One thing that is good about the copy; absent in marks of older versions. */
  praise?: Bilingual | null;
  remarks: Remark[];
  similarity: number | null;
  sim_paper: number | null;
  pose: { angle: number; scale: number; shift: [number, number] } | null;
  /** turned_by: degrees clockwise by which the picture is to be turned to be upright, if that is why it was refused. */
  refused: null | (Bilingual & { code: string; turned_by?: number | null });
  source: [HeightSource, HeightSource] | null;
  source_text: Bilingual | null;
  /** Maps fractions of the copy's cell to fractions of the master's, origin top left: x' = a x + c y + e, y' = b x + d y + f. */
  align: { matrix: [number, number, number, number, number, number] } | null;
  /** [x, y, r]: fractions of the picture's own cell; r: distance from the other's line, 0 to 1. */
  residual: { copy: [number, number, number][]; master: [number, number, number][] } | null;
  /** Whose marks the calibration was fitted to, if it is not the default one. */
  calibration?: string | null;
  seconds: number;
};

export type NumberChange = { before: number; after: number; change: "better" | "same" | "worse" };
export type FaultChange = Bilingual & {
  status: "gone" | "smaller" | "same" | "larger" | "turned" | "new";
  kind: string;
  stroke: number | null;
  /** Index among the remarks of the later attempt. */
  remark: number | null;
};
/** What an attempt changed against the one before, of the same writer and master. */
export type Progress = {
  previous: { id: string; created: string };
  mark: NumberChange & Bilingual;
  parts: (NumberChange & Bilingual & { name: string })[];
  faults: FaultChange[];
};

export type TeacherMark = { teacher: string; mark: number; note: string };
export type Attempt = {
  id: string | null;
  work: WorkCard;
  person: { id: string; name: string } | null;
  kind: "pen" | "photo" | "simulated";
  grid: Grid;
  created: string;
  task: string | null;
  picture: string | null;
  mark: Mark;
  teacher_marks: TeacherMark[];
  /** Null for a first attempt and a visitor's, and in lists. */
  progress?: Progress | null;
};
export type Grid = "mi" | "jiu" | "tian" | "";

export type Job = {
  id: string;
  kind: string;
  state: "queued" | "running" | "done" | "failed" | "cancelled";
  done: number;
  total: number;
  message: string;
  result: Record<string, unknown>;
  error: Bilingual | null;
};
