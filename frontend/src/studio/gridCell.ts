// The cell of a printed grid (米字格, 田字格, rows of squares) that the writing in a photograph stands in.

import type { Square } from "./crop";
import { type Box, type InkPart, type InkParts, type Mask, partsOf, widened, withoutThin } from "./photoInk";

/** A printed line. at: where it is in the middle of the picture; slope: how far it moves for each pixel along it. */
type Line = { at: number; slope: number; from: number; to: number; thickness: number };
type Way = "across" | "down";
/** A square between four lines; rank: of the cell that the writing is in, lower is likelier. */
type Candidate = { square: Square; across: [Line, Line]; down: [Line, Line]; share: number; distance: number };

/** The cell, and the ink without its printed lines; cell: null where none is printed around ink. */
export type FoundCell = { cell: Square | null; ink: InkParts };

const SLOPES = Array.from({ length: 17 }, (_, k) => (k - 8) * 0.01); // a sheet that lies askew by five degrees at most
const LEAST_RUN = 0.1; // of the shorter side: a line
const WIDEST_LINE = { dark: 0.022, coloured: 0.05 }; // of the longer side; what is wider is a stroke or an edge
const WIDEST_GAP = 0.008; // of the longer side, in a line; the lines inside a 米字格 are dashed wider
const MOST_LINES = 40; // each way; a cross-hatched picture is no sheet
const SQUARENESS = 0.1; // by which width and height of a cell may differ
const INSET = 0.35; // of a line's width: the cell is within its lines, which a photograph blurs
const LEAST_CELL = 0.04; // of the longer side
const COVERED = 0.75; // of an edge of a cell, by its printed line
const LEAST_INSIDE = 0.004; // of a cell, by ink: a cell without writing
const MOST_CUT = 0.15; // of the ink in a cell, beyond its edges
const CROSSED = 0.03; // of a cell's side, by ink on lines inside it: these divide one cell, not several
const STROKE_OVER_LINE = 1.5; // width of strokes over that of a printed line of the same darkness

/** drawn: ink and printed lines. */
export function findCell(ink: Mask, drawn: Mask): FoundCell {
  const across = linesOf(drawn, ink, "across");
  const down = linesOf(drawn, ink, "down");
  const dark = [...across.map((line) => darkness(ink, line, "across")), ...down.map((line) => darkness(ink, line, "down"))];
  const bare = withoutLines(ink, across, down);
  const parts = partsOf(bare);
  const candidates = across.length > 1 && down.length > 1 ? candidatesOf(across, down, parts, ink) : [];
  const found = best(candidates, bare);
  if (!found) return { cell: null, ink: partsOf(ink) };
  const edges = [...found.across, ...found.down];
  const printedDark = dark.some((share, k) => share > 0.5 && edges.includes([...across, ...down][k]!));
  const thickness = Math.max(...edges.map((line) => line.thickness));
  if (!printedDark) return { cell: found.square, ink: parts };
  const within = parts.parts.filter((part) => centreIn(part, found.square));
  const written = !candidates.some((one) => isBeside(one.square, found.square)) && strokeWidth(parts, within) < STROKE_OVER_LINE * thickness;
  if (written) return { cell: null, ink: partsOf(ink) }; // 囗, with strokes as thin as the lines
  return { cell: found.square, ink: partsOf(withoutThin(bare, thickness + 1)) };
}

/** Straight thin lines, the longest of neighbours. */
function linesOf(drawn: Mask, ink: Mask, way: Way): Line[] {
  const { width, height } = drawn;
  const [length, count] = way === "across" ? [width, height] : [height, width];
  const [step, stride] = way === "across" ? [1, width] : [width, 1];
  const thick = widened(drawn, way === "across" ? 0 : 1, way === "across" ? 1 : 0).on;
  const gap = Math.max(2, Math.round(WIDEST_GAP * Math.max(width, height)));
  const least = LEAST_RUN * Math.min(width, height);
  const found: Line[] = [];
  for (const slope of SLOPES) {
    const shifts = Int32Array.from({ length }, (_, along) => Math.round(slope * (along - length / 2)));
    for (let at = 0; at < count; at++) {
      let [begin, last, from, to] = [-1, -gap - 1, 0, -1];
      for (let along = 0; along < length; along++) {
        const place = at + shifts[along]!;
        if (place < 0 || place >= count || !thick[place * stride + along * step]) continue;
        if (along - last > gap) begin = along;
        last = along;
        if (last - begin > to - from) [from, to] = [begin, last];
      }
      if (to - from >= least) found.push({ at, slope, from, to, thickness: 0 });
    }
  }
  found.sort((a, b) => b.to - b.from - (a.to - a.from) || Math.abs(a.slope) - Math.abs(b.slope));
  const apart = Math.max(3, 0.012 * Math.max(width, height));
  const lines: Line[] = [];
  const seen: Line[] = [];
  for (const line of found) {
    const middle = (line.from + line.to) / 2;
    const isSame = (one: Line) => one.from < line.to && one.to > line.from && Math.abs(placeOf(one, middle, length) - placeOf(line, middle, length)) < Math.max(apart, one.thickness);
    if (seen.some(isSame)) continue;
    const widths = crossings(drawn, line, way);
    const whole = { ...line, at: line.at + median(widths.map(([begin, end, place]) => (begin + end) / 2 - place)), thickness: median(widths.map(([begin, end]) => end - begin + 1)) };
    seen.push(whole);
    const widest = WIDEST_LINE[darkness(ink, whole, way) > 0.5 ? "dark" : "coloured"] * Math.max(width, height);
    if (whole.thickness <= Math.max(2, widest)) lines.push(whole);
    if (lines.length >= MOST_LINES || seen.length > 4 * MOST_LINES) break;
  }
  return lines.sort((a, b) => a.at - b.at);
}

const median = (values: number[]): number => values.sort((a, b) => a - b)[Math.floor(values.length / 2)] ?? 0;

const placeOf = (line: Line, along: number, length: number): number => line.at + line.slope * (along - length / 2);

/** Where what is drawn begins and ends across a line, at many places along it, and where the line is. */
function crossings({ on, width, height }: Mask, line: Line, way: Way): [from: number, to: number, place: number][] {
  const [length, count] = way === "across" ? [width, height] : [height, width];
  const at = (along: number, place: number) => on[way === "across" ? place * width + along : along * width + place];
  const found: [number, number, number][] = [];
  for (let along = line.from; along <= line.to; along += 2) {
    const place = Math.round(placeOf(line, along, length));
    const start = [place, place - 1, place + 1].find((one) => one >= 0 && one < count && at(along, one));
    if (start === undefined) continue;
    let [from, to] = [start, start];
    while (from > 0 && at(along, from - 1)) from--;
    while (to < count - 1 && at(along, to + 1)) to++;
    found.push([from, to, place]);
  }
  return found;
}

/** The share of a line that is as dark as ink. */
function darkness({ on, width, height }: Mask, line: Line, way: Way): number {
  const length = way === "across" ? width : height;
  const count = way === "across" ? height : width;
  let dark = 0;
  for (let along = line.from; along <= line.to; along++) {
    const place = Math.round(placeOf(line, along, length));
    const near = [place - 1, place, place + 1].filter((one) => one >= 0 && one < count);
    if (near.some((one) => on[way === "across" ? one * width + along : along * width + one])) dark++;
  }
  return dark / (line.to - line.from + 1);
}

/** The ink beside the lines; where a stroke crosses a line, both are cut apart. */
function withoutLines(ink: Mask, across: Line[], down: Line[]): Mask {
  const on = ink.on.slice();
  const { width, height } = ink;
  for (const [lines, way] of [[across, "across"], [down, "down"]] as const)
    for (const line of lines) {
      if (darkness(ink, line, way) < 0.5) continue; // printed in a colour: no ink is on it
      const [length, count] = way === "across" ? [width, height] : [height, width];
      const half = line.thickness / 2 + 1;
      for (let along = line.from; along <= line.to; along++) {
        const place = placeOf(line, along, length);
        for (let k = Math.max(0, Math.ceil(place - half)); k <= Math.min(count - 1, place + half); k++) on[way === "across" ? k * width + along : along * width + k] = 0;
      }
    }
  return { on, width, height };
}

function candidatesOf(across: Line[], down: Line[], parts: InkParts, ink: Mask): Candidate[] {
  const { width, height } = parts;
  const found: Candidate[] = [];
  for (const [k, top] of across.entries())
    for (const bottom of across.slice(k + 1))
      for (const [j, left] of down.entries())
        for (const right of down.slice(j + 1)) {
          const middle = (a: Line, b: Line, along: number, length: number) => (placeOf(a, along, length) + placeOf(b, along, length)) / 2;
          const x0 = placeOf(left, (top.at + bottom.at) / 2, height);
          const x1 = placeOf(right, (top.at + bottom.at) / 2, height);
          const y0 = placeOf(top, middle(left, right, (top.at + bottom.at) / 2, height), width);
          const y1 = placeOf(bottom, middle(left, right, (top.at + bottom.at) / 2, height), width);
          const [wide, tall] = [x1 - x0, y1 - y0];
          if (Math.min(wide, tall) < LEAST_CELL * Math.max(width, height) || Math.abs(wide - tall) > SQUARENESS * Math.max(wide, tall)) continue;
          const covers = (line: Line, from: number, to: number) => Math.min(line.to, to) - Math.max(line.from, from) >= COVERED * (to - from);
          if (!covers(top, x0, x1) || !covers(bottom, x0, x1) || !covers(left, y0, y1) || !covers(right, y0, y1)) continue;
          const inset = (INSET * (top.thickness + bottom.thickness + left.thickness + right.thickness)) / 4;
          const side = (wide + tall) / 2 - 2 * inset;
          const square = { x: (x0 + x1 - side) / 2, y: (y0 + y1 - side) / 2, side };
          const share = cutShare(parts, square);
          if (share === null || share > MOST_CUT) continue;
          const distance = Math.hypot((x0 + x1) / 2 - width / 2, (y0 + y1) / 2 - height / 2) / Math.min(width, height);
          found.push({ square, across: [top, bottom], down: [left, right], share, distance });
        }
  return found.filter((one) => isOneCell(one, across, down, ink));
}

/** The share of the ink of a square that lies beyond its edges; null for a square without writing. */
function cutShare(parts: InkParts, square: Square): number | null {
  let [inside, cut] = [0, 0];
  for (const part of parts.parts) {
    const own = centreIn(part, square);
    if (own) inside += part.count;
    if (own ? !boxWithin(part, square) : boxTouches(part, square)) {
      const within = countWithin(parts, part, square);
      cut += own ? part.count - within : within;
    }
  }
  return inside < LEAST_INSIDE * square.side * square.side ? null : cut / inside;
}

/** Whether two squares are neighbours in a row or a column. */
const isBeside = (a: Square, b: Square): boolean => {
  const [dx, dy] = [Math.abs(a.x - b.x) / b.side, Math.abs(a.y - b.y) / b.side];
  return Math.abs(a.side - b.side) < SQUARENESS * b.side && Math.min(dx, dy) < SQUARENESS && Math.abs(Math.max(dx, dy) - 1) < 2 * SQUARENESS;
};

const centreIn = (box: Box, { x, y, side }: Square): boolean => {
  const [u, v] = [(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2];
  return u > x && u < x + side && v > y && v < y + side;
};
const boxWithin = (box: Box, { x, y, side }: Square): boolean => box.x0 >= x - 0.5 && box.y0 >= y - 0.5 && box.x1 <= x + side - 0.5 && box.y1 <= y + side - 0.5;
const boxTouches = (box: Box, { x, y, side }: Square): boolean => box.x1 > x && box.x0 < x + side && box.y1 > y && box.y0 < y + side;

function countWithin({ numbers, width }: InkParts, part: InkPart, { x, y, side }: Square): number {
  let count = 0;
  for (let v = Math.max(part.y0, Math.ceil(y)); v <= Math.min(part.y1, y + side); v++)
    for (let u = Math.max(part.x0, Math.ceil(x)); u <= Math.min(part.x1, x + side); u++) if (numbers[v * width + u] === part.number) count++;
  return count;
}

/** Whether the lines inside a square, if there are any, divide one cell: then ink crosses them. */
function isOneCell({ square: { x, y, side }, across: [top, bottom], down: [left, right] }: Candidate, across: Line[], down: Line[], ink: Mask): boolean {
  const between = (lines: Line[], first: Line, last: Line, from: number, to: number) =>
    lines.filter((line) => line.at > first.at + 0.15 * side && line.at < last.at - 0.15 * side && Math.min(line.to, to) - Math.max(line.from, from) > COVERED * side);
  const inner: [Line, Way][] = [
    ...between(across, top, bottom, x, x + side).map((line): [Line, Way] => [line, "across"]),
    ...between(down, left, right, y, y + side).map((line): [Line, Way] => [line, "down"]),
  ];
  if (!inner.length) return true;
  const crossed = inner.reduce((sum, [line, way]) => sum + crossedLength(ink, line, way, way === "across" ? x : y, side), 0);
  return crossed > CROSSED * side;
}

/** For how many pixels of a line there is ink on both sides of it. */
function crossedLength({ on, width, height }: Mask, line: Line, way: Way, from: number, side: number): number {
  const [length, count] = way === "across" ? [width, height] : [height, width];
  const beside = line.thickness / 2 + 2;
  const at = (along: number, place: number) => place >= 0 && place < count && on[way === "across" ? place * width + along : along * width + place] === 1;
  let crossed = 0;
  for (let along = Math.ceil(from + 0.04 * side); along < from + 0.96 * side; along++) {
    const place = placeOf(line, along, length);
    if (at(along, Math.round(place - beside)) && at(along, Math.round(place + beside))) crossed++;
  }
  return crossed;
}

/** The cell nearest to the middle of the picture; of squares within each other the largest, since each of them is one cell. */
function best(candidates: Candidate[], bare: Mask): Candidate | null {
  const outermost = candidates.filter(({ square: a }) => !candidates.some(({ square: b }) => b.side > 1.3 * a.side && b.x < a.x + a.side / 2 && b.x + b.side > a.x + a.side / 2 && b.y < a.y + a.side / 2 && b.y + b.side > a.y + a.side / 2));
  const cost = (one: Candidate) => one.distance + 2 * one.share - (0.1 * one.square.side) / bare.width;
  return outermost.reduce<Candidate | null>((first, one) => (first && cost(first) <= cost(one) ? first : one), null);
}

/** Mean width of strokes: twice their area over their outline. */
function strokeWidth({ numbers, width }: InkParts, parts: readonly InkPart[]): number {
  const own = new Set(parts.map((part) => part.number));
  let [area, outline] = [0, 0];
  for (let k = 0; k < numbers.length; k++) {
    if (!own.has(numbers[k]!)) continue;
    area++;
    if ([k - 1, k + 1, k - width, k + width].some((next) => numbers[next] !== numbers[k])) outline++;
  }
  return outline ? (2 * area) / outline : 0;
}
