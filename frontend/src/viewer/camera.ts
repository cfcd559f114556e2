// Camera moves: orbit, pan, zoom. The sheet is never seen from behind or upside down.

import { type Camera, clamp, type Mode } from "./state";

export const FIELD_OF_VIEW = 28;
const MAX_ANGLE = (84 * Math.PI) / 180;
const MIN_DISTANCE = 0.04;
const MAX_DISTANCE = 8;
/** Margin around the sheet, which leaves space for its relief. */
const MARGIN = 1.06;
/** The first view of a surface: degrees to the right, degrees from below. */
const OBLIQUE_VIEW: [number, number] = [16, -34];

/** A camera that sees the whole sheet: straight on, or obliquely in the modes that show depth. */
export function fitCamera(mode: Mode, sheet: { wide: number; tall: number }, aspect: number): Camera {
  const straight: Camera = [0, 0, 1, 0, 0, 0];
  const aslant = mode === "surface" || mode === "mesh";
  const [x, y, z] = aslant ? orbit(straight, (OBLIQUE_VIEW[0] * Math.PI) / 180, (OBLIQUE_VIEW[1] * Math.PI) / 180) : straight;
  const away = fittingDistance([x, y, z], sheet, aspect) * MARGIN;
  return [x * away, y * away, z * away, 0, 0, 0];
}

/** How far away along `back`, a unit vector, the camera must be to see all four corners. */
function fittingDistance(back: readonly [number, number, number], { wide, tall }: { wide: number; tall: number }, aspect: number): number {
  const half = Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180));
  const level = Math.hypot(back[0], back[2]);
  const right = [back[2] / level, 0] as const; // x and y are enough: the corners lie in z = 0
  const up = [(-back[0] * back[1]) / level, level] as const;
  const corners = [-1, 1].flatMap((i) => [-1, 1].map((k) => [(i * wide) / 2, (k * tall) / 2] as const));
  const along = (axis: readonly [number, number], [x, y]: readonly [number, number]) => axis[0] * x + axis[1] * y;
  return Math.max(
    ...corners.map((p) => along([back[0], back[1]], p) + Math.max(Math.abs(along(right, p)) / aspect, Math.abs(along(up, p))) / half),
  );
}

/** Turns the camera around its target: `right` about the vertical axis, `up` about the horizontal one; radians. */
export function orbit(camera: Camera, right: number, up: number): Camera {
  const [x, y, z, tx, ty, tz] = camera;
  const [dx, dy, dz] = [x - tx, y - ty, z - tz];
  const distance = Math.hypot(dx, dy, dz);
  const azimuth = clamp(Math.atan2(dx, dz) + right, -MAX_ANGLE, MAX_ANGLE);
  const elevation = clamp(Math.asin(clamp(dy / distance, -1, 1)) + up, -MAX_ANGLE, MAX_ANGLE);
  const level = Math.cos(elevation) * distance;
  return [tx + Math.sin(azimuth) * level, ty + Math.sin(elevation) * distance, tz + Math.cos(azimuth) * level, tx, ty, tz];
}

/** Moves camera and target in the image plane; `right` and `up` in fractions of the picture's height. */
export function pan(camera: Camera, right: number, up: number): Camera {
  const [x, y, z, tx, ty, tz] = camera;
  const back = [x - tx, y - ty, z - tz] as const;
  const distance = Math.hypot(...back);
  const whole = 2 * distance * Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180));
  const level = Math.hypot(back[0], back[2]) || 1;
  const sideways = [back[2] / level, 0, -back[0] / level] as const;
  const upward = [(-back[0] * back[1]) / (level * distance), level / distance, (-back[2] * back[1]) / (level * distance)] as const;
  const by = [0, 1, 2].map((k) => (sideways[k]! * right + upward[k]! * up) * whole);
  const aim = [clamp(tx + by[0]!, -1, 1), clamp(ty + by[1]!, -1, 1), clamp(tz + by[2]!, -0.5, 0.5)] as const;
  return [aim[0] + back[0], aim[1] + back[1], aim[2] + back[2], ...aim];
}

/** Moves nearer (factor < 1) or farther, towards the pointer at `right`, `up`: fractions of the picture's height from its middle. */
export function zoom(camera: Camera, factor: number, right = 0, up = 0): Camera {
  const [x, y, z, tx, ty, tz] = camera;
  const distance = Math.hypot(x - tx, y - ty, z - tz);
  const ratio = clamp(distance * factor, MIN_DISTANCE, MAX_DISTANCE) / distance;
  const moved = pan(camera, right * (1 - ratio), up * (1 - ratio));
  const [mx, my, mz] = [moved[3], moved[4], moved[5]];
  return [mx + (x - tx) * ratio, my + (y - ty) * ratio, mz + (z - tz) * ratio, mx, my, mz];
}

export function interpolateCamera(from: Camera, to: Camera, t: number): Camera {
  return from.map((value, k) => value + (to[k]! - value) * t) as Camera;
}
