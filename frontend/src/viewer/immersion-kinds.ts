// Which kinds of immersion this browser has; apart from immersion.ts, so that asking costs nothing.

export type Immersion = "immersive-vr" | "immersive-ar";
type Asked = { isSessionSupported(kind: Immersion): Promise<boolean> };

export async function immersions(): Promise<Immersion[]> {
  const xr = (navigator as { xr?: Asked }).xr;
  if (!xr) return [];
  const kinds: Immersion[] = ["immersive-vr", "immersive-ar"];
  const can = await Promise.all(kinds.map((kind) => xr.isSessionSupported(kind).catch(() => false)));
  return kinds.filter((_, k) => can[k]);
}
