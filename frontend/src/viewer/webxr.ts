// A sheet in a headset (WebXR): half a metre large, at arm's length, lit by the same lamp.

import type { SheetScene } from "./scene";
import type { ViewState } from "./state";
import type { SessionMode } from "./types";

type XRSystem = { requestSession(kind: SessionMode, options?: object): Promise<XRSession> };

/** Shows the sheet until the session ends. Rejects if the browser or the user refuses. */
export async function enterSession(sheetScene: SheetScene, state: () => ViewState, kind: SessionMode): Promise<void> {
  const xr = (navigator as { xr?: XRSystem }).xr;
  if (!xr) throw new Error("this browser has no WebXR");
  const session = await xr.requestSession(kind, { optionalFeatures: ["local"] });
  const { renderer, scene, sheet, camera } = sheetScene;
  const { mode } = state();
  sheetScene.draw({ ...state(), mode: mode === "sheet" ? "surface" : mode, lens: "none", camera: null }, null); // the whole
  renderer.xr.enabled = true;
  renderer.xr.setReferenceSpaceType("local");
  await renderer.xr.setSession(session);
  sheet.scale.setScalar(0.5);
  sheet.position.set(0, -0.1, -0.7);
  renderer.setAnimationLoop(() => renderer.render(scene, camera));
  await new Promise<void>((resolve) => session.addEventListener("end", () => resolve()));
  renderer.setAnimationLoop(null);
  renderer.xr.enabled = false;
  sheet.scale.setScalar(1);
  sheet.position.set(0, 0, 0);
}

type XRSupport = { isSessionSupported(kind: SessionMode): Promise<boolean> };

/** The kinds of session that the browser and its devices support. */
export async function supportedSessions(): Promise<SessionMode[]> {
  const xr = (navigator as { xr?: XRSupport }).xr;
  if (!xr) return [];
  const kinds: SessionMode[] = ["immersive-vr", "immersive-ar"];
  const can = await Promise.all(kinds.map((kind) => xr.isSessionSupported(kind).catch(() => false)));
  return kinds.filter((_, k) => can[k]);
}
