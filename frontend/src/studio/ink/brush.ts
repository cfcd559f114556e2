// Points of the hand -> footprints of a brush. Pure, and free of pixels: all lengths are fractions of the cell.
//
// A brush answers late and softly: its force follows pressure, or without a sensor the speed (slow is thick), and
// changes by so much per length at most. It is put down at a slant, and leaves in a point when it leaves in flight.

import { hasPressure, type Sample, type Stroke } from "./strokes";

/** One footprint: an ellipse with half axes a (long) and b, its long axis turned by `angle` radians, clockwise on screen. */
export type Stamp = { x: number; y: number; a: number; b: number; angle: number };

/** A place on the smoothed path. s: length so far; speed: cells per second; force: 0-1. */
type PathPoint = { x: number; y: number; t: number; s: number; speed: number; force: number; tiltX: number; tiltY: number };

/**
 * pitch: between footprints, share of the radius. brisk: speed at which an unpressed brush is at half force.
 * give: how much of the radius the force may change per radius of path. lag: length, in radii, over which force is averaged.
 * held: turn of the resting footprint, radians; flat: its b / a. lean: a / b at 90 degrees of tilt, less 1.
 */
export type BrushSettings = {
  spacing: number; halfForceSpeed: number; maxForceSlope: number; meanLength: number; restAngle: number; restAspect: number; tiltStretch: number;
};

export const BRUSH: BrushSettings = { spacing: 0.18, halfForceSpeed: 2.2, maxForceSlope: 0.75, meanLength: 0.5, restAngle: 0.5, restAspect: 0.84, tiltStretch: 0.9 };

const STILL = 1e-4; // of the cell: nearer points are one
const LEAST = 0.12; // a brush that touches leaves at least this share of its width

export function brushStamps(stroke: Stroke, brush: BrushSettings = BRUSH): Stamp[] {
  const points = mergeRepeated(stroke.points);
  const first = points[0];
  if (!first) return [];
  const dwell = stroke.points.at(-1)![2] - stroke.points[0]![2];
  if (points.length < 2 || pathLength(points) < 0.25 * stroke.size) return dotStamps(stroke, points, dwell, brush);
  const path = resample(smoothPoints(points), stroke.size * brush.spacing * 0.5);
  const places = withForce(path, stroke, brush);
  return spaceStamps(taperEnds(places, stroke), stroke, brush);
}

/** Points that stand apart in place; the later time and the firmer pressure of those that do not. */
export function mergeRepeated(points: readonly Sample[]): Sample[] {
  const kept: Sample[] = [];
  for (const point of points) {
    const last = kept.at(-1);
    if (last && Math.hypot(point[0] - last[0], point[1] - last[1]) < STILL) {
      kept[kept.length - 1] = [last[0], last[1], point[2], Math.max(last[3], point[3]), point[4], point[5]];
    } else kept.push(point);
  }
  return kept;
}

const pathLength = (points: readonly Sample[]): number =>
  points.reduce((sum, [x, y], k) => sum + (k ? Math.hypot(x - points[k - 1]![0], y - points[k - 1]![1]) : 0), 0);

/** One pass of 1-2-1 over the places takes the tremor of a sensor, and leaves ends and corners where they are. */
export function smoothPoints(points: readonly Sample[]): Sample[] {
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

/** Places along a centripetal Catmull-Rom curve through the points, about `step` apart; time and pressure in proportion. */
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

/** Barry and Goldman's pyramid with knots at the square root of the distances: no loops, no overshoot at corners. */
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

/** Speed and force at every place of the path. */
function withForce(path: readonly Sample[], stroke: Stroke, brush: BrushSettings): PathPoint[] {
  const pressed = hasPressure(stroke.points);
  const places = withSpeed(path);
  const wet = stroke.ink - 0.5;
  const raw = places.map((place, k) =>
    pressed ? fromPressure(path[k]![3]) : fromSpeed(place.speed * (1 - 0.8 * wet), brush),
  );
  const soft = movingMean(raw, places, brush.meanLength * stroke.size);
  const force = limitSlope(soft, places, brush.maxForceSlope / stroke.size);
  const swell = 1 + 0.24 * wet; // wet ink runs a little beyond the hairs
  return places.map((place, k) => ({ ...place, force: Math.min(1.12, force[k]! * swell) }));
}

/** A pen's sensor is stiff at first; a brush gives at once. */
export const fromPressure = (pressure: number): number => LEAST + (1 - LEAST) * Math.pow(clamp(pressure), 0.72);

/** Slow is thick: full force at rest, about half of it at a brisk speed. */
export const fromSpeed = (speed: number, brush: BrushSettings = BRUSH): number =>
  0.28 + 0.6 / (1 + Math.pow(Math.max(0, speed) / brush.halfForceSpeed, 1.3));

const clamp = (value: number): number => Math.min(1, Math.max(0, value));

function withSpeed(path: readonly Sample[]): PathPoint[] {
  let s = 0;
  const places = path.map(([x, y, t, , tiltX, tiltY], k): PathPoint => {
    const before = path[k - 1];
    if (before) s += Math.hypot(x - before[0], y - before[1]);
    return { x, y, t, s, speed: 0, force: 0, tiltX, tiltY };
  });
  // Over a window of time: events come in bursts, and the time between two of them says little.
  let [low, high] = [0, 0];
  for (const place of places) {
    while (places[low]!.t < place.t - 30) low++;
    while (high + 1 < places.length && places[high]!.t < place.t + 30) high++;
    const [from, to] = [places[low]!, places[high]!];
    place.speed = (to.s - from.s) / Math.max(0.012, (to.t - from.t) / 1000);
  }
  return places;
}

/** Mean over `reach` of the path to either side. */
function movingMean(values: readonly number[], places: readonly PathPoint[], reach: number): number[] {
  const sums = [0];
  for (const value of values) sums.push(sums.at(-1)! + value);
  let [low, high] = [0, 0];
  return values.map((_, k) => {
    while (places[low]!.s < places[k]!.s - reach) low++;
    while (high < places.length && places[high]!.s <= places[k]!.s + reach) high++;
    return (sums[high]! - sums[low]!) / (high - low);
  });
}

/** The values, lowered where they would rise or fall faster than `rate` per length. */
export function limitSlope(values: readonly number[], places: readonly { s: number }[], rate: number): number[] {
  const out = [...values];
  const step = (k: number, from: number) => {
    out[k] = Math.min(out[k]!, out[from]! + rate * Math.abs(places[k]!.s - places[from]!.s));
  };
  for (let k = 1; k < out.length; k++) step(k, k - 1);
  for (let k = out.length - 2; k >= 0; k--) step(k, k + 1);
  return out;
}

/** Put down slantwise: narrow for half a width. Lifted: blunt from rest, in a long point from flight. */
function taperEnds(places: PathPoint[], stroke: Stroke): PathPoint[] {
  const pressed = hasPressure(stroke.points);
  const whole = places.at(-1)!.s;
  const flight = exitFlight(places);
  const entry = Math.min(0.3 * whole, stroke.size * (pressed ? 0.5 : 0.8));
  const exit = Math.min(0.6 * whole, stroke.size * (pressed ? 0.5 + flight : 0.4 + 2.6 * flight));
  const tip = pressed ? 0.35 : 0.62 - 0.55 * flight;
  return places.map((place) => {
    const rise = 0.55 + 0.45 * smooth(place.s / Math.max(entry, 1e-6));
    const fall = tip + (1 - tip) * Math.pow(clamp((whole - place.s) / Math.max(exit, 1e-6)), 0.8);
    return { ...place, force: place.force * rise * fall };
  });
}

/** How far the brush flies off at the end: 0 at rest to 1 in full flight. */
export function exitFlight(places: readonly { speed: number }[]): number {
  const end = places.slice(-12);
  const mean = end.reduce((sum, place) => sum + place.speed, 0) / Math.max(1, end.length);
  return smooth((mean - 0.35) / 1.6);
}

const smooth = (u: number): number => clamp(u) ** 2 * (3 - 2 * clamp(u));

/** Footprints so near that their edge is even, and no nearer. */
function spaceStamps(places: readonly PathPoint[], stroke: Stroke, brush: BrushSettings): Stamp[] {
  const stamps: Stamp[] = [];
  let next = 0;
  for (const [k, place] of places.entries()) {
    if (place.s < next && k !== places.length - 1) continue;
    const stamp = footprint(place, stroke.size * Math.max(place.force, LEAST * 0.5), brush);
    stamps.push(stamp);
    next = place.s + Math.max(stamp.b, 0.1 * stroke.size) * brush.spacing;
  }
  return stamps;
}

/** An upright brush rests a little slanted, as a right hand holds it; a tilted one lies along its shaft. */
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

/** A brush put down and lifted on the spot: a drop that grows while it stays, and longer than wide (點). */
function dotStamps(stroke: Stroke, points: readonly Sample[], dwell: number, brush: BrushSettings): Stamp[] {
  const [first, last] = [points[0]!, points.at(-1)!];
  const firm = hasPressure(stroke.points) ? fromPressure(Math.max(...points.map((point) => point[3]))) : 0;
  const full = stroke.size * Math.max(firm, 0.45 + 0.45 * smooth(dwell / 450)) * (0.9 + 0.2 * stroke.ink);
  const [dx, dy] = [last[0] - first[0], last[1] - first[1]];
  const path = Math.hypot(dx, dy);
  const turn = path > 0.05 * stroke.size ? Math.atan2(dy, dx) : Math.PI / 4;
  const length = Math.max(path, 0.5 * full);
  return Array.from({ length: 9 }, (_, k): Stamp => {
    const u = k / 8;
    const place = { x: first[0] + Math.cos(turn) * length * u, y: first[1] + Math.sin(turn) * length * u };
    return footprint({ ...place, tiltX: last[4], tiltY: last[5] }, full * (0.35 + 0.65 * Math.pow(u, 0.7)), brush);
  });
}
