// The viewer's interface, and the types that its parts share.

import type { ViewerFacts, Work } from "../types";
import type { HeightField, ProfilePoint } from "./heightfield";
import type { Camera, SheetLine, ViewState } from "./state";

/** Kinds of WebXR session. */
export type SessionMode = "immersive-vr" | "immersive-ar";
export type Tool = "light" | "move" | "section" | "ruler" | "pin";
/** x, y: fractions of the sheet, origin top left. */
export type SheetPoint = { x: number; y: number; height: number };

export type ViewerOptions = Partial<Omit<ViewState, "camera">> & {
  camera?: Camera | null;
  /** false: reacts to no pointer and no keys. */
  interactive?: boolean;
  onChange?: (state: ViewState) => void;
  /** With the tool `pin`: called with the point that was clicked, in fractions of the sheet. */
  onPoint?: (point: SheetPoint) => void;
  signal?: AbortSignal;
};

export interface Viewer {
  readonly facts: ViewerFacts;
  readonly state: ViewState;
  /** null without WebGL2, when the picture and a message are shown. */
  readonly field: HeightField | null;
  readonly canvas: HTMLCanvasElement | null;
  /** Height between two contour lines. */
  readonly interval: number;
  tool: Tool;
  set(partial: Partial<ViewState>): void;
  /** As `set`, but animated, unless the user prefers reduced motion. */
  animateTo(partial: Partial<ViewState>, milliseconds?: number): void;
  /** Shares mode, light, look, exaggeration and camera with another viewer, both ways; null ends that. */
  link(other: Viewer | null): void;
  /** The view as a PNG. */
  snapshot(): Promise<Blob>;
  /** The whole flat sheet under the current light, in the resolution of its maps, as a PNG. */
  relit(): Promise<Blob>;
  resize(): void;
  dispose(): void;
  /** The point of the sheet under (x, y), CSS pixels from the host's top left. */
  pick(x: number, y: number): SheetPoint | null;
  section(line: SheetLine): ProfilePoint[];
  /** Where a point of the sheet is in the host, in CSS pixels from its top left. */
  project(u: number, v: number): { x: number; y: number } | null;
  /** Calls `listener` after each frame, until the function returned is called. */
  onDraw(listener: () => void): () => void;
  /** Enters immersive VR or AR where the browser has it. */
  immerse(kind: SessionMode): Promise<void>;
}

/** Files that the download menu offers: name to URL. `page` is the page in one file. */
export type Downloads = Partial<Work["files"]> & { page?: string };
