// The shaders' arithmetic, line for line as in shaders.ts, so that it can be tested against rumu.relight without a GPU.

export type Vec3 = [number, number, number];

/** sRGB code value in [0, 1] to linear light. */
export function srgbToLinear(c: number): number {
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
}

/** Linear light in [0, 1] to its sRGB code value. */
export function linearToSrgb(c: number): number {
  return c <= 0.0031308 ? c * 12.92 : 1.055 * c ** (1 / 2.4) - 0.055;
}

/** Three bytes n * 127.5 + 127.5, given in [0, 1] as a texture gives them, to a unit normal; y up. */
export function decodeNormal(c: Vec3): Vec3 {
  const n: Vec3 = [(c[0] * 255 - 127.5) / 127.5, (c[1] * 255 - 127.5) / 127.5, (c[2] * 255 - 127.5) / 127.5];
  const length = Math.max(Math.hypot(...n), 1e-6);
  return [n[0] / length, n[1] / length, n[2] / length];
}

/** The normal of the same surface `k` times as high. */
export function exaggerate(n: Vec3, k: number): Vec3 {
  const m: Vec3 = [n[0] * k, n[1] * k, n[2]];
  const length = Math.max(Math.hypot(...m), 1e-6);
  return [m[0] / length, m[1] / length, m[2] / length];
}

/** Unit vector to the lamp. Degrees: tilt counter-clockwise from +x, slant from +z. */
export function lampDirection(tilt: number, slant: number): Vec3 {
  const [t, s] = [(tilt * Math.PI) / 180, (slant * Math.PI) / 180];
  return [Math.cos(t) * Math.sin(s), Math.sin(t) * Math.sin(s), Math.cos(s)];
}

/** Lambert's law: 0 where the surface turns away. */
export function shading(n: Vec3, l: Vec3): number {
  return Math.max(n[0] * l[0] + n[1] * l[1] + n[2] * l[2], 0);
}

/** One lit pixel, linear, in [0, 1]; albedo linear. */
export function lambert(albedo: Vec3, n: Vec3, l: Vec3): Vec3 {
  const s = shading(n, l);
  return [Math.min(albedo[0] * s, 1), Math.min(albedo[1] * s, 1), Math.min(albedo[2] * s, 1)];
}

/** Colour of the lamp unless exact shading is chosen: a little warm, linear. */
export const WARM: Vec3 = [1, 0.955, 0.88];
/** Exposure: as a photographer would, let in more light when the lamp is low, but only in part. */
export function exposure(l: Vec3): number {
  return Math.max(l[2], 0.3) ** -0.7;
}

/** Default strength of the ink's sheen. */
export const SHEEN = 0.34;

/** Specular highlight of dark ink (Blinn-Phong): drawn for looks, not measured. `toEye` is a unit vector. */
export function inkSheen(albedo: Vec3, n: Vec3, l: Vec3, toEye: Vec3): number {
  const dark = Math.max(1 - (0.2126 * albedo[0] + 0.7152 * albedo[1] + 0.0722 * albedo[2]), 0);
  const half: Vec3 = [l[0] + toEye[0], l[1] + toEye[1], l[2] + toEye[2]];
  const length = Math.max(Math.hypot(...half), 1e-6);
  const towards = Math.max((n[0] * half[0] + n[1] * half[1] + n[2] * half[2]) / length, 0);
  return dark * dark * towards ** 22 * Math.min(shading(n, l) * 4, 1);
}

/** One pixel under the warm lamp with its exposure, linear; `sheen` 0 leaves the ink matt. */
export function warmLamp(albedo: Vec3, n: Vec3, l: Vec3, toEye: Vec3, sheen: number): Vec3 {
  const [s, g, k] = [shading(n, l), inkSheen(albedo, n, l, toEye) * sheen, exposure(l)];
  return [
    Math.min((albedo[0] * s + g) * k * WARM[0], 1),
    Math.min((albedo[1] * s + g) * k * WARM[1], 1),
    Math.min((albedo[2] * s + g) * k * WARM[2], 1),
  ];
}

/** Weights of the three photographs in the paper's three-lamp mixture; degrees; `slant` is that of the photographs. */
export function mixtureWeights(tilt: number, newSlant: number, slant: number): Vec3 {
  const [t, fresh, old] = [(tilt * Math.PI) / 180, (newSlant * Math.PI) / 180, (slant * Math.PI) / 180];
  const sideways = Math.sin(fresh) / Math.sin(old);
  const facing = Math.cos(fresh) / Math.cos(old);
  return [
    (sideways * (Math.cos(t) - Math.sin(t)) + facing) / 2,
    sideways * Math.sin(t),
    (facing - sideways * (Math.cos(t) + Math.sin(t))) / 2,
  ];
}

/** One pixel of the three-lamp mixture, linear, clamped at 0: the attached shadow. */
export function mixPhotographs(a: number, b: number, c: number, weights: Vec3): number {
  return Math.max(weights[0] * a + weights[1] * b + weights[2] * c, 0);
}

/** How far `height` stands between two contour lines, 0 on a line and 0.5 in the middle; `interval` apart. */
export function contourDistance(height: number, interval: number): number {
  const v = height / interval;
  return Math.abs(v - Math.floor(v + 0.5));
}

/** Bilinear sample of a map at fractions (u, v), origin top left, clamped at the border; `at` gives texel (column, row). */
export function bilinear(u: number, v: number, width: number, height: number, at: (c: number, r: number) => number): number {
  const x = Math.min(Math.max(u * width - 0.5, 0), width - 1);
  const y = Math.min(Math.max(v * height - 0.5, 0), height - 1);
  const [c, r] = [Math.floor(x), Math.floor(y)];
  const [c1, r1] = [Math.min(c + 1, width - 1), Math.min(r + 1, height - 1)];
  const top = at(c, r) + (at(c1, r) - at(c, r)) * (x - c);
  const bottom = at(c, r1) + (at(c1, r1) - at(c, r1)) * (x - c);
  return top + (bottom - top) * (y - r);
}

// Thirty-three anchors of viridis (S. van der Walt and N. Smith, released under CC0), linear between them.
// prettier-ignore
export const ANCHORS: readonly Vec3[] = [
  [0.267, 0.0049, 0.3294], [0.277, 0.0502, 0.3755], [0.2823, 0.0946, 0.417], [0.2829, 0.1354, 0.453],
  [0.2789, 0.1749, 0.483], [0.2708, 0.2133, 0.5066], [0.2593, 0.2507, 0.5244], [0.2454, 0.2867, 0.537],
  [0.2302, 0.3213, 0.5455], [0.2148, 0.3545, 0.551], [0.2, 0.3864, 0.5545], [0.1861, 0.4173, 0.5567],
  [0.1733, 0.4474, 0.5579], [0.1613, 0.477, 0.5581], [0.1497, 0.5064, 0.5573], [0.1384, 0.5358, 0.5551],
  [0.1281, 0.5651, 0.5509], [0.1209, 0.5945, 0.5442], [0.1203, 0.6238, 0.5343], [0.131, 0.6529, 0.5208],
  [0.1554, 0.6815, 0.5032], [0.193, 0.7096, 0.4812], [0.2415, 0.7366, 0.4545], [0.2986, 0.7624, 0.423],
  [0.3629, 0.7867, 0.3866], [0.433, 0.8091, 0.3453], [0.5081, 0.8292, 0.2992], [0.5873, 0.847, 0.2489],
  [0.6694, 0.8622, 0.1954], [0.7529, 0.8751, 0.1427], [0.8359, 0.8861, 0.1025], [0.9166, 0.8961, 0.1008],
  [0.9932, 0.9062, 0.1439],
];

/** sRGB code values in [0, 1] of a height at `t` between lowest (0) and highest (1). */
export function heightColour(t: number): Vec3 {
  const x = Math.min(Math.max(t, 0), 1) * (ANCHORS.length - 1);
  const k = Math.min(Math.floor(x), ANCHORS.length - 2);
  const [low, high] = [ANCHORS[k]!, ANCHORS[k + 1]!];
  const f = x - k;
  return [low[0] + (high[0] - low[0]) * f, low[1] + (high[1] - low[1]) * f, low[2] + (high[2] - low[2]) * f];
}

export function cssColour(t: number): string {
  return `rgb(${heightColour(t).map((v) => Math.round(v * 255)).join(" ")})`;
}
