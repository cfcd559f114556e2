// A model of a brush: from the points of a stroke to stamps, the ellipses it is painted with. All lengths are fractions
// of the cell.
//
// A brush responds late and softly: its force follows the pressure or, without a sensor, the speed (slow is thick), and
// its change per length is limited. The stroke begins slanted, and ends in a point if the brush leaves at speed.

import { hasPressure, type Sample, type Stroke } from "./strokes";

/** An ellipse with half axes a (long) and b, its long axis turned by `angle` radians, clockwise on screen. */
export type Stamp = { x: number; y: number; a: number; b: number; angle: number };

/** A point of the smoothed path. s: length so far; speed: cells per second; force: 0-1. */
type PathPoint = { x: number; y: number; t: number; s: number; speed: number; force: number; tiltX: number; tiltY: number };

/**
 * spacing: between stamps, fraction of the radius. halfForceSpeed: cells per second at which the force is about half, without
 * a pressure sensor. maxForceSlope: largest change of force per radius of path. meanLength: length, in radii, over which the
 * force is averaged. restAngle: angle of an upright brush's stamp, radians; restAspect: its b / a. tiltStretch: a / b at 90
 * degrees of tilt, less 1.
 */
export type BrushSettings = {
  spacing: number; halfForceSpeed: number; maxForceSlope: number; meanLength: number;
  restAngle: number; restAspect: number; tiltStretch: number;
};

export const BRUSH: BrushSettings = {
  spacing: 0.18, halfForceSpeed: 2.2, maxForceSlope: 0.75, meanLength: 0.5, restAngle: 0.5, restAspect: 0.84, tiltStretch: 0.9,
};

const MIN_DISTANCE = 1e-4; // fraction of the cell; nearer points are merged
const MIN_FORCE = 0.12; // a touching brush leaves at least this fraction of its width

export function brushStamps(stroke: Stroke, brush: BrushSettings = BRUSH): Stamp[] {
  const points = mergeRepeated(stroke.points);
  const first = points[0];
  if (!first) return [];
  const dwell = stroke.points.at(-1)![2] - stroke.points[0]![2];
  if (points.length < 2 || pathLength(points) < 0.25 * stroke.size) return dotStamps(stroke, points, dwell, brush);
  const path = resample(smoothPoints(points), stroke.size * brush.spacing * 0.5);
  const track = withForce(path, stroke, brush);
  return spaceStamps(taperEnds(track, stroke), stroke, brush);
}

/** Merges points in the same place into one, with the later time and the firmer pressure. */
export function mergeRepeated(points: readonly Sample[]): Sample[] {
  const merged: Sample[] = [];
  for (const point of points) {
    const last = merged.at(-1);
    if (last && Math.hypot(point[0] - last[0], point[1] - last[1]) < MIN_DISTANCE) {
      merged[merged.length - 1] = [last[0], last[1], point[2], Math.max(last[3], point[3]), point[4], point[5]];
    } else merged.push(point);
  }
  return merged;
}

const pathLength = (points: readonly Sample[]): number =>
  points.reduce((sum, [x, y], k) => sum + (k ? Math.hypot(x - points[k - 1]![0], y - points[k - 1]![1]) : 0), 0);

/** One pass of a 1-2-1 filter over the positions, against sensor noise; ends and corners stay. */
function smoothPoints(points: readonly Sample[]): Sample[] {
  return points.map((point, k) => {
    const before = points[k - 1];
    const after = points[k + 1];
    if (!before || !after || isCorner(before, point, after)) return point;
    return [(before[0] + 2 * point[0] + after[0]) / 4, (before[1] + 2 * point[1] + after[1]) / 4, ...tail(point)];
  });
}

const tail = ([, , t, p, tx, ty]: Sample): [number, number, number, number] => [t, p, tx, ty];

function isCorner(a: Sample, b: Sample, c: Sample): boolean {
  const turn = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
  return turn < 0.5 * Math.hypot(b[0] - a[0], b[1] - a[1]) * Math.hypot(c[0] - b[0], c[1] - b[1]);
}

/** Samples of a centripetal Catmull-Rom curve through the points, about `step` apart; time and pressure are linear between points. */
export function resample(points: readonly Sample[], step: number): Sample[] {
  const out: Sample[] = [points[0]!];
  for (let k = 0; k + 1 < points.length; k++) {
    const [b, c] = [points[k]!, points[k + 1]!];
    const [a, d] = [points[k - 1] ?? extrapolate(c, b), points[k + 2] ?? extrapolate(b, c)];
    const pieces = Math.max(1, Math.ceil(Math.hypot(c[0] - b[0], c[1] - b[1]) / step));
    for (let i = 1; i <= pieces; i++) out.push(catmullRom(a, b, c, d, i / pieces));
  }
  return out;
}

/** The point as far past `to` as `from` is before it. */
const extrapolate = (from: Sample, to: Sample): Sample => [2 * to[0] - from[0], 2 * to[1] - from[1], ...tail(to)];

/** Barry and Goldman's pyramid, with knots at the square roots of the distances, which avoids loops and overshoot at corners. */
function catmullRom(a: Sample, b: Sample, c: Sample, d: Sample, u: number): Sample {
  const gap = (p: Sample, q: Sample) => Math.max(Math.sqrt(Math.hypot(q[0] - p[0], q[1] - p[1])), 1e-6);
  const [t0, t1] = [0, gap(a, b)];
  const t2 = t1 + gap(b, c);
  const t3 = t2 + gap(c, d);
  const t = t1 + u * (t2 - t1);
  const mix = (p: number, q: number, from: number, to: number) => (p * (to - t) + q * (t - from)) / (to - from);
  const at = (i: 0 | 1): number => {
    const [p, q, r] = [mix(a[i], b[i], t0, t1), mix(b[i], c[i], t1, t2), mix(c[i], d[i], t2, t3)];
    return mix(mix(p, q, t0, t2), mix(q, r, t1, t3), t1, t2);
  };
  const between = (i: 2 | 3 | 4 | 5): number => b[i] + (c[i] - b[i]) * u;
  return [at(0), at(1), between(2), between(3), between(4), between(5)];
}

/** Speed and force at each point of the path. */
function withForce(path: readonly Sample[], stroke: Stroke, brush: BrushSettings): PathPoint[] {
  const pressed = hasPressure(stroke.points);
  const track = withSpeed(path);
  const wet = stroke.ink - 0.5;
  const raw = track.map((point, k) =>
    pressed ? fromPressure(path[k]![3]) : fromSpeed(point.speed * (1 - 0.8 * wet), brush),
  );
  const soft = movingMean(raw, track, brush.meanLength * stroke.size);
  const force = limitSlope(soft, track, brush.maxForceSlope / stroke.size);
  const swell = 1 + 0.24 * wet; // wet ink spreads a little beyond the hairs
  return track.map((point, k) => ({ ...point, force: Math.min(1.12, force[k]! * swell) }));
}

/** Force of a pen's pressure: a sensor is stiff at first, a brush yields at once. */
export const fromPressure = (pressure: number): number => MIN_FORCE + (1 - MIN_FORCE) * Math.pow(clamp(pressure), 0.72);

/** Force without a pressure sensor: slow is thick. */
export const fromSpeed = (speed: number, brush: BrushSettings = BRUSH): number =>
  0.28 + 0.6 / (1 + Math.pow(Math.max(0, speed) / brush.halfForceSpeed, 1.3));

const clamp = (value: number): number => Math.min(1, Math.max(0, value));

function withSpeed(path: readonly Sample[]): PathPoint[] {
  let s = 0;
  const track = path.map(([x, y, t, , tiltX, tiltY], k): PathPoint => {
    const before = path[k - 1];
    if (before) s += Math.hypot(x - before[0], y - before[1]);
    return { x, y, t, s, speed: 0, force: 0, tiltX, tiltY };
  });
  // Over a window of time: events come in bursts, so the time between two of them says little.
  let [low, high] = [0, 0];
  for (const point of track) {
    while (track[low]!.t < point.t - 30) low++;
    while (high + 1 < track.length && track[high]!.t < point.t + 30) high++;
    const [from, to] = [track[low]!, track[high]!];
    point.speed = (to.s - from.s) / Math.max(0.012, (to.t - from.t) / 1000);
  }
  return track;
}

/** Moving mean over the path within `reach` on either side. */
function movingMean(values: readonly number[], track: readonly PathPoint[], reach: number): number[] {
  const sums = [0];
  for (const value of values) sums.push(sums.at(-1)! + value);
  let [low, high] = [0, 0];
  return values.map((_, k) => {
    while (track[low]!.s < track[k]!.s - reach) low++;
    while (high < track.length && track[high]!.s <= track[k]!.s + reach) high++;
    return (sums[high]! - sums[low]!) / (high - low);
  });
}

/** Lowers the values where they rise or fall faster than `rate` per length. */
export function limitSlope(values: readonly number[], track: readonly { s: number }[], rate: number): number[] {
  const out = [...values];
  const step = (k: number, from: number) => {
    out[k] = Math.min(out[k]!, out[from]! + rate * Math.abs(track[k]!.s - track[from]!.s));
  };
  for (let k = 1; k < out.length; k++) step(k, k - 1);
  for (let k = out.length - 2; k >= 0; k--) step(k, k + 1);
  return out;
}

/** Narrows the ends: the beginning slanted, the end blunt if the brush stopped, in a long point if it left at speed. */
function taperEnds(track: PathPoint[], stroke: Stroke): PathPoint[] {
  const pressed = hasPressure(stroke.points);
  const whole = track.at(-1)!.s;
  const flight = exitFlight(track);
  const entry = Math.min(0.3 * whole, stroke.size * (pressed ? 0.5 : 0.8));
  const exit = Math.min(0.6 * whole, stroke.size * (pressed ? 0.5 + flight : 0.4 + 2.6 * flight));
  const tip = pressed ? 0.35 : 0.62 - 0.55 * flight;
  return track.map((point) => {
    const rise = 0.55 + 0.45 * smooth(point.s / Math.max(entry, 1e-6));
    const fall = tip + (1 - tip) * Math.pow(clamp((whole - point.s) / Math.max(exit, 1e-6)), 0.8);
    return { ...point, force: point.force * rise * fall };
  });
}

/** How fast the brush leaves at the end: 0 at rest to 1 in full flight. */
function exitFlight(track: readonly { speed: number }[]): number {
  const end = track.slice(-12);
  const mean = end.reduce((sum, point) => sum + point.speed, 0) / Math.max(1, end.length);
  return smooth((mean - 0.35) / 1.6);
}

const smooth = (u: number): number => clamp(u) ** 2 * (3 - 2 * clamp(u));

/** Stamps just near enough to each other that the edge is smooth. */
function spaceStamps(track: readonly PathPoint[], stroke: Stroke, brush: BrushSettings): Stamp[] {
  const stamps: Stamp[] = [];
  let next = 0;
  for (const [k, point] of track.entries()) {
    if (point.s < next && k !== track.length - 1) continue;
    const stamp = footprint(point, stroke.size * Math.max(point.force, MIN_FORCE * 0.5), brush);
    stamps.push(stamp);
    next = point.s + Math.max(stamp.b, 0.1 * stroke.size) * brush.spacing;
  }
  return stamps;
}

/** The stamp of an upright brush is slightly turned, as a right hand holds it; that of a tilted one points along the shaft. */
export function footprint(
  at: { x: number; y: number; tiltX: number; tiltY: number }, radius: number, brush: BrushSettings = BRUSH,
): Stamp {
  const { lean, turn } = penTilt(at.tiltX, at.tiltY);
  if (lean < 0.09) return { x: at.x, y: at.y, a: radius, b: radius * brush.restAspect, angle: brush.restAngle };
  const long = 1 + brush.tiltStretch * lean * lean;
  const [a, b] = [radius * long, radius / Math.sqrt(long)];
  const aside = 0.35 * (a - b); // the tip stays where the pen is; the belly lies towards the shaft
  return { x: at.x + aside * Math.cos(turn), y: at.y + aside * Math.sin(turn), a, b, angle: turn };
}

/** lean: sine of the angle between shaft and upright, 0-1. turn: where the shaft points, radians clockwise from +x on screen. */
export function penTilt(tiltX: number, tiltY: number): { lean: number; turn: number } {
  const limit = (degrees: number) => Math.tan((Math.min(89, Math.max(-89, degrees)) * Math.PI) / 180);
  const [x, y] = [limit(tiltX), limit(tiltY)];
  return { lean: Math.sin(Math.atan(Math.hypot(x, y))), turn: Math.atan2(y, x) };
}

/** A dot (點): the brush put down and lifted in one place; longer than wide, and larger the longer it stayed. */
function dotStamps(stroke: Stroke, points: readonly Sample[], dwell: number, brush: BrushSettings): Stamp[] {
  const [first, last] = [points[0]!, points.at(-1)!];
  const firm = hasPressure(stroke.points) ? fromPressure(Math.max(...points.map((point) => point[3]))) : 0;
  const full = stroke.size * Math.max(firm, 0.45 + 0.45 * smooth(dwell / 450)) * (0.9 + 0.2 * stroke.ink);
  const [dx, dy] = [last[0] - first[0], last[1] - first[1]];
  const moved = Math.hypot(dx, dy);
  const turn = moved > 0.05 * stroke.size ? Math.atan2(dy, dx) : Math.PI / 4;
  const length = Math.max(moved, 0.5 * full);
  return Array.from({ length: 9 }, (_, k): Stamp => {
    const u = k / 8;
    const point = { x: first[0] + Math.cos(turn) * length * u, y: first[1] + Math.sin(turn) * length * u };
    return footprint({ ...point, tiltX: last[4], tiltY: last[5] }, full * (0.35 + 0.65 * Math.pow(u, 0.7)), brush);
  });
}
