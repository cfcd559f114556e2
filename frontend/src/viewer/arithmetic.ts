// The shaders' arithmetic, line for line as in glsl.ts, so that it can be tested against rumu.relight without a GPU.

export type Vec3 = [number, number, number];

/** sRGB code value in [0, 1] to linear light. */
export function decode(c: number): number {
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
}

/** Linear light in [0, 1] to its sRGB code value. */
export function encode(c: number): number {
  return c <= 0.0031308 ? c * 12.92 : 1.055 * c ** (1 / 2.4) - 0.055;
}

/** Three bytes n * 127.5 + 127.5, given in [0, 1] as a texture gives them, to a unit normal; y up. */
export function decodeNormal(c: Vec3): Vec3 {
  const n: Vec3 = [(c[0] * 255 - 127.5) / 127.5, (c[1] * 255 - 127.5) / 127.5, (c[2] * 255 - 127.5) / 127.5];
  const length = Math.max(Math.hypot(...n), 1e-6);
  return [n[0] / length, n[1] / length, n[2] / length];
}

/** The normal of the same surface `k` times as high. */
export function exaggerated(n: Vec3, k: number): Vec3 {
  const m: Vec3 = [n[0] * k, n[1] * k, n[2]];
  const length = Math.max(Math.hypot(...m), 1e-6);
  return [m[0] / length, m[1] / length, m[2] / length];
}

/** Unit vector to the lamp. Degrees: tilt counter-clockwise from +x, slant from +z. */
export function lamp(tilt: number, slant: number): Vec3 {
  const [t, s] = [(tilt * Math.PI) / 180, (slant * Math.PI) / 180];
  return [Math.cos(t) * Math.sin(s), Math.sin(t) * Math.sin(s), Math.cos(s)];
}

/** Lambert's law: 0 where the surface turns away. */
export function shading(n: Vec3, l: Vec3): number {
  return Math.max(n[0] * l[0] + n[1] * l[1] + n[2] * l[2], 0);
}

/** One lit pixel, linear, in [0, 1]; albedo linear. */
export function lit(albedo: Vec3, n: Vec3, l: Vec3): Vec3 {
  const s = shading(n, l);
  return [Math.min(albedo[0] * s, 1), Math.min(albedo[1] * s, 1), Math.min(albedo[2] * s, 1)];
}

/** Colour of the lamp that is shown unless exactness is asked for: a little warm, linear. */
export const WARM: Vec3 = [1, 0.955, 0.88];
/** A photographer lets in more light when the lamp stands low; so does the page, in part. */
export function gain(l: Vec3): number {
  return Math.max(l[2], 0.3) ** -0.7;
}

/** Light that glances off dark ink towards the eye: drawn for the reader, not measured. `toEye` a unit vector. */
export function glance(albedo: Vec3, n: Vec3, l: Vec3, toEye: Vec3): number {
  const dark = Math.max(1 - (0.2126 * albedo[0] + 0.7152 * albedo[1] + 0.0722 * albedo[2]), 0);
  const half: Vec3 = [l[0] + toEye[0], l[1] + toEye[1], l[2] + toEye[2]];
  const length = Math.max(Math.hypot(...half), 1e-6);
  const towards = Math.max((n[0] * half[0] + n[1] * half[1] + n[2] * half[2]) / length, 0);
  return dark * dark * towards ** 22 * Math.min(shading(n, l) * 4, 1);
}

/** One pixel as a warm lamp and a kind exposure show it, linear; `sheen` 0 leaves the ink matt. */
export function underLamp(albedo: Vec3, n: Vec3, l: Vec3, toEye: Vec3, sheen: number): Vec3 {
  const [s, g, k] = [shading(n, l), glance(albedo, n, l, toEye) * sheen, gain(l)];
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
export function mixed(a: number, b: number, c: number, weights: Vec3): number {
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
