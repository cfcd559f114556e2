// The seam: what other pages may use of the viewer.

export { createViewer, type Place, type Tool, type Viewer, type ViewerOptions } from "./viewer";
export { lightAt } from "./light";
export { MODES, START, stateFromQuery, stateToQuery, type Camera, type Lens, type Line, type Look, type Mode, type ViewState } from "./state";
export type { ProfilePoint } from "./heightfield";
