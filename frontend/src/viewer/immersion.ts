// A sheet in a headset: half a metre large, at arm's length, lit by the same lamp. Browsers load this only when asked.

import type { Stage } from "./stage";
import type { ViewState } from "./state";

export type Immersion = "immersive-vr" | "immersive-ar";
type XRLike = {
  isSessionSupported(kind: Immersion): Promise<boolean>;
  requestSession(kind: Immersion, options?: object): Promise<XRSession>;
};
const xr = (): XRLike | undefined => (navigator as { xr?: XRLike }).xr;

/** Which kinds this browser can enter. */
export async function immersions(): Promise<Immersion[]> {
  const kinds: Immersion[] = ["immersive-vr", "immersive-ar"];
  const can = await Promise.all(kinds.map((kind) => xr()?.isSessionSupported(kind).catch(() => false) ?? false));
  return kinds.filter((_, k) => can[k]);
}

/** Shows the sheet until the session ends. */
export async function immerse(stage: Stage, state: () => ViewState, kind: Immersion): Promise<void> {
  const session = await xr()!.requestSession(kind, { optionalFeatures: ["local-floor"] });
  const { renderer, scene, sheet, camera } = stage;
  const shown = () => ({ ...state(), mode: state().mode === "sheet" ? ("surface" as const) : state().mode });
  stage.draw(shown(), null);
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
