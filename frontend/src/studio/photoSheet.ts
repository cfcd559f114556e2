// What lies around the sheet in a photograph: a table or a felt darker than the paper, up to the picture's edge. It is no ink.

import { boxOf, type Mask, partsOf, type Raster, valley, widened } from "./photoInk";

const ALONG_EDGE = 0.5; // of one edge of the picture, in one piece: a stroke that leaves the picture is shorter
const SHEET = { least: 0.1, most: 0.98, solid: 0.55 }; // of the picture; and of the box around the sheet
const DARKER = 0.62; // lightness beyond the sheet's edge over that within: a shadow leaves more
const BESIDE = { beyond: 24, within: 6 }; // pixels from the sheet's edge, where the two are compared: wider than strokes that run into it
const SOFT = 3; // pixels of the edge, which a photograph blurs

/** The picture with the paper's colours in place of what lies around the sheet; the same picture where the sheet fills it. */
export function onPaperAlone(raster: Raster): Raster {
  const light = lightOf(raster);
  const first = valley(light);
  const second = valley(light.filter((value) => value < first)); // paper in a shade may be nearer to the table than to bright paper
  const found = [first, second].map((limit) => surroundings(light, limit, raster)).filter((one) => one !== null);
  const darkest = found.reduce<Surroundings | null>((best, one) => (best && best.ratio <= one.ratio ? best : one), null);
  return darkest ? painted(raster, widened(darkest.mask, SOFT, SOFT)) : raster;
}

const lightOf = ({ data, width, height }: Raster): Float32Array =>
  Float32Array.from({ length: width * height }, (_, k) => Math.max(data[4 * k]!, data[4 * k + 1]!, data[4 * k + 2]!) / 255);

type Surroundings = { mask: Mask; ratio: number };

/** What is darker than a limit and hangs together with an edge of the picture; null where that is no table around a sheet. */
function surroundings(light: Float32Array, limit: number, { width, height }: Raster): Surroundings | null {
  const dark: Mask = { on: Uint8Array.from(light, (value) => Number(value < limit)), width, height };
  const { numbers, parts } = partsOf(dark);
  const outer = new Set(parts.filter((part) => longestContact(numbers, part.number, width, height) >= ALONG_EDGE).map((part) => part.number));
  if (!outer.size) return null;
  const mask: Mask = { ...dark, on: Uint8Array.from(numbers, (number) => Number(outer.has(number))) };
  const sheet = partsOf({ ...mask, on: mask.on.map((value) => 1 - value) }).parts.reduce((most, part) => (part.count > most.count ? part : most), { ...NOTHING, count: 0 });
  const box = boxOf([sheet])!;
  const share = sheet.count / light.length;
  if (share < SHEET.least || share > SHEET.most || sheet.count < SHEET.solid * (box.x1 - box.x0 + 1) * (box.y1 - box.y0 + 1)) return null;
  const ratio = stepAt(mask, light);
  return ratio < DARKER ? { mask, ratio } : null;
}

const NOTHING = { x0: 0, y0: 0, x1: 0, y1: 0 };

/** The longest run of a part along an edge of the picture, as a share of that edge. */
function longestContact(numbers: Int32Array, number: number, width: number, height: number): number {
  const run = (length: number, at: (k: number) => number) => {
    let [most, now] = [0, 0];
    for (let k = 0; k < length; k++) {
      now = numbers[at(k)] === number ? now + 1 : 0;
      most = Math.max(most, now);
    }
    return most / length;
  };
  const below = (height - 1) * width;
  return Math.max(run(width, (k) => k), run(width, (k) => below + k), run(height, (k) => k * width), run(height, (k) => k * width + width - 1));
}

/** The median lightness beyond the sheet's edge over that just within. */
function stepAt(mask: Mask, light: Float32Array): number {
  const blurred = widened(mask, SOFT, SOFT).on;
  const within = widened(mask, SOFT + BESIDE.within, SOFT + BESIDE.within).on;
  const beyond = widened({ ...mask, on: mask.on.map((value) => 1 - value) }, BESIDE.beyond, BESIDE.beyond).on;
  const median = (values: Float32Array) => values.sort()[Math.floor(values.length / 2)] ?? 0;
  return median(light.filter((_, k) => mask.on[k] && beyond[k])) / Math.max(1e-6, median(light.filter((_, k) => within[k] && !blurred[k])));
}

/** A picture in which each pixel of a mask has the colour of the nearest other one in its row, or in the nearest row that has one. */
function painted({ data, width, height }: Raster, { on }: Mask): Raster {
  const next = data.slice();
  const filled: number[] = [];
  const copy = (from: number, to: number) => next.copyWithin(4 * to, 4 * from, 4 * from + 4);
  for (let y = 0; y < height; y++) {
    const kept = Array.from({ length: width }, (_, x) => x).filter((x) => !on[y * width + x]);
    if (!kept.length) continue;
    filled.push(y);
    let k = 0;
    for (let x = 0; x < width; x++) {
      while (k + 1 < kept.length && Math.abs(kept[k + 1]! - x) <= Math.abs(kept[k]! - x)) k++;
      if (on[y * width + x]) copy(y * width + kept[k]!, y * width + x);
    }
  }
  if (!filled.length) return { data, width, height };
  for (let y = 0; y < height; y++) {
    const nearest = filled.reduce((best, row) => (Math.abs(row - y) < Math.abs(best - y) ? row : best), filled[0]!);
    if (nearest !== y) next.copyWithin(4 * y * width, 4 * nearest * width, 4 * (nearest + 1) * width);
  }
  return { data: next, width, height };
}
