// The seam: what other pages may use of the viewer.

export { createViewer } from "./viewer";
export type { Place, Tool, Viewer, ViewerOptions } from "./types";
export { lightAt } from "./light";
export { MODES, START, stateFromQuery, stateToQuery, type Camera, type Lens, type Line, type Look, type Mode, type ViewState } from "./state";
export type { ProfilePoint } from "./heightfield";
