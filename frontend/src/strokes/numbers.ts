// Where numbers stand on the strokes that they belong to: on the stroke, whole within the picture, clear of one another.

export type Point = readonly [x: number, y: number];
export type Box = readonly [x0: number, y0: number, x1: number, y1: number];

/** What a number is about, in fractions of the picture: lines; without lines a box; without both the whole. */
export type Numbered = { lines: readonly (readonly Point[])[]; box?: Box | null };

/** x, y: the middle of the number, in fractions of the picture. tether: the place on the stroke, if the number had to stand beside it. */
export type NumberPlace = { x: number; y: number; tether: Point | null };

/** width, height of the picture, radius of a number, all in one unit. from: where on a stroke a number is wanted. */
export type NumberFrame = { width: number; height: number; radius: number; from: "start" | "middle" };

const CLEARANCE = 1.08; // between the middles of two numbers, in diameters
const STEP = 0.25; // between two places on a stroke that are tried, in radii
const RINGS = 60; // of places beside the stroke that are tried, a quarter of a radius apart
const DIRECTIONS = 24;
const BESIDE = 1.05; // from so many radii on, a number counts as standing beside its stroke

type Place = readonly [x: number, y: number];

/** A place for each number. Those with the fewest places on their stroke choose first. */
export function placeNumbers(items: readonly Numbered[], frame: NumberFrame): NumberPlace[] {
  const wanted = items.map((item) => placesOn(item, frame));
  const order = [...items.keys()].sort((a, b) => wanted[a]!.length - wanted[b]!.length || a - b);
  const taken: Place[] = [];
  const found: NumberPlace[] = Array(items.length);
  for (const k of order) {
    const places = wanted[k]!;
    const chosen = places.find((place) => isFree(place, taken, frame)) ?? besideStroke(places, taken, frame);
    taken.push(chosen);
    const nearest = nearestOf(chosen, onStroke(items[k]!, frame));
    const apart = nearest !== null && distance(nearest, chosen) > BESIDE * frame.radius;
    found[k] = { x: chosen[0] / frame.width, y: chosen[1] / frame.height, tether: apart ? [nearest[0] / frame.width, nearest[1] / frame.height] : null };
  }
  return found;
}

/** Places where a number may stand at all, the best first, moved into the picture. */
function placesOn(item: Numbered, frame: NumberFrame): Place[] {
  return onStroke(item, frame).map((place) => inside(place, frame));
}

/** Places on the longest line, along the upper edge of the box, or along that of the picture. */
function onStroke({ lines, box }: Numbered, frame: NumberFrame): Place[] {
  const { width, height, radius } = frame;
  const scaled = lines.map((line) => line.map(([x, y]): Place => [x * width, y * height])).filter((line) => line.length > 0);
  if (scaled.length) {
    const longest = scaled.reduce((a, b) => (lengthOf(b) > lengthOf(a) ? b : a));
    const places = alongLine(longest, radius * STEP);
    const start = frame.from === "start" ? 0 : (places.length - 1) / 2;
    const others = scaled.filter((line) => line !== longest).flatMap((line) => alongLine(line, radius * STEP));
    return [...places.map((place, k) => ({ place, off: Math.abs(k - start) })).sort((a, b) => a.off - b.off).map(({ place }) => place), ...others];
  }
  const [x0, y0, x1] = box ?? [0, 0, 1];
  return alongLine([[x0 * width, y0 * height], [x1 * width, y0 * height]], radius * STEP);
}

function alongLine(line: readonly Place[], step: number): Place[] {
  const places: Place[] = [line[0]!];
  for (const [k, b] of line.slice(1).entries()) {
    const a = line[k]!;
    const pieces = Math.max(1, Math.ceil(distance(a, b) / step));
    for (let n = 1; n <= pieces; n++) places.push([a[0] + ((b[0] - a[0]) * n) / pieces, a[1] + ((b[1] - a[1]) * n) / pieces]);
  }
  return places;
}

/** The free place nearest to the stroke; the best place on it where the whole picture is full. */
function besideStroke(places: readonly Place[], taken: readonly Place[], frame: NumberFrame): Place {
  for (let ring = 1; ring <= RINGS; ring++)
    for (const [x, y] of places)
      for (let k = 0; k < DIRECTIONS; k++) {
        const turn = (2 * Math.PI * k) / DIRECTIONS;
        const reach = (ring * frame.radius) / 4;
        const place = inside([x + reach * Math.cos(turn), y + reach * Math.sin(turn)], frame);
        if (isFree(place, taken, frame)) return place;
      }
  return places[0]!;
}

const isFree = (place: Place, taken: readonly Place[], { radius }: NumberFrame): boolean =>
  taken.every((other) => distance(place, other) >= 2 * radius * CLEARANCE - 1e-9);

const inside = ([x, y]: Place, { width, height, radius }: NumberFrame): Place => [clamp(x, radius, width - radius), clamp(y, radius, height - radius)];

const clamp = (value: number, low: number, high: number): number => Math.max(low, Math.min(high, value));

const distance = (a: Place, b: Place): number => Math.hypot(a[0] - b[0], a[1] - b[1]);

const nearestOf = (place: Place, others: readonly Place[]): Place | null =>
  others.reduce<Place | null>((best, other) => (best && distance(place, best) <= distance(place, other) ? best : other), null);

const lengthOf = (line: readonly Place[]): number => line.slice(1).reduce((sum, b, k) => sum + distance(line[k]!, b), 0);
