// The viewer's interface, and the types that its parts share.

import type { ViewerFacts, Work } from "../types";
import type { HeightField, ProfilePoint } from "./heightfield";
import type { Camera, SheetLine, ViewState } from "./state";

export type Tool = "light" | "move" | "section" | "ruler" | "pin";
export type SheetPoint = { x: number; y: number; height: number };

export type ViewerOptions = Partial<Omit<ViewState, "camera">> & {
  camera?: Camera | null;
  /** false: no pointer, no keys; a picture that others move. */
  interactive?: boolean;
  onChange?: (state: ViewState) => void;
  /** With the tool `pin`: where a point was set, as fractions of the sheet. */
  onPoint?: (place: SheetPoint) => void;
  signal?: AbortSignal;
};

export interface Viewer {
  readonly facts: ViewerFacts;
  readonly state: ViewState;
  /** null where there is no WebGL2: the host then shows the picture and says so. */
  readonly field: HeightField | null;
  readonly canvas: HTMLCanvasElement | null;
  /** Units of height between two contour lines. */
  readonly interval: number;
  tool: Tool;
  set(partial: Partial<ViewState>): void;
  /** As `set`, but gently; at once for those who asked for less motion. */
  animateTo(partial: Partial<ViewState>, milliseconds?: number): void;
  /** Shares mode, light, look, exaggeration and camera with another, both ways; null parts them. */
  link(other: Viewer | null): void;
  /** The view as a PNG. */
  snapshot(): Promise<Blob>;
  /** The whole flat sheet under the present light, at the size of its maps, as a PNG. */
  relit(): Promise<Blob>;
  resize(): void;
  dispose(): void;
  /** What lies under (x, y), CSS pixels from the host's top left: fractions of the sheet and the height there. */
  pick(x: number, y: number): SheetPoint | null;
  section(line: SheetLine): ProfilePoint[];
  /** CSS pixels from the host's top left of a point of the sheet. */
  project(u: number, v: number): { x: number; y: number } | null;
  /** Called after each drawing; the answer stops it. */
  onDraw(listener: () => void): () => void;
  /** Enters immersive VR or AR where the browser has it. */
  immerse(kind: "immersive-vr" | "immersive-ar"): Promise<void>;
}

/** Files that the download menu offers: name to URL. `page` is the page in one file. */
export type Downloads = Partial<Work["files"]> & { page?: string };
