// The ink in a photograph of a sheet: which pixels are ink, and which of them belong together. All lengths in pixels of the small copy.

/** A small copy of a photograph, RGBA row by row from the top. */
export type Raster = { data: Uint8ClampedArray; width: number; height: number };
/** Pixels of one colour each: 1 where the thing is. */
export type Mask = { on: Uint8Array; width: number; height: number };
export type Box = { x0: number; y0: number; x1: number; y1: number };
/** Ink that hangs together. number: its value in `InkParts.numbers`. count: of its pixels. The box has its last row and column inside. */
export type InkPart = Box & { number: number; count: number };
export type InkParts = { numbers: Int32Array; width: number; height: number; parts: InkPart[] };

/** Longer side of the copy in which ink is sought, in pixels: enough for a hairline, and quick on a phone. */
export const COPY_SIDE = 512;

const BLOCKS = 32; // along the longer side: the paper's lightness is measured in each
const REACH = 3; // blocks around in which the lightest is paper, so that a broad stroke is not taken for grey paper
const PAPER_QUANTILE = 0.9; // of the lightness in a block
const INK_BELOW = { least: 0.5, most: 0.72 }; // lightness of ink over that of the paper
const LINE_BELOW = 0.9; // the same of a printed line, in its darkest colour
const LEAST_INK = 0.0006; // of the picture; with less, the ink may have a colour
const SPECK = 4e-5; // of the picture: a part below this is dust

type Channel = "lightest" | "darkest";

/** Dark ink; where there is none, ink in a colour. Printed lines in a colour are not dark. */
export function findInk(raster: Raster): Mask {
  for (const channel of ["lightest", "darkest"] as const) {
    const share = overPaper(raster, channel);
    const limit = Math.min(INK_BELOW.most, Math.max(INK_BELOW.least, valley(share)));
    const mask = below(share, limit, raster);
    if (channel === "darkest" || countOf(mask) > LEAST_INK * mask.on.length) return mask;
  }
  throw new Error("unreachable");
}

/** Everything that is darker than the paper in any colour: ink, and printed lines. */
export const findDrawn = (raster: Raster): Mask => below(overPaper(raster, "darkest"), LINE_BELOW, raster);

const below = (share: Float32Array, limit: number, { width, height }: Raster): Mask => ({ on: Uint8Array.from(share, (value) => Number(value < limit)), width, height });
const countOf = ({ on }: Mask): number => on.reduce((sum, value) => sum + value, 0);

/** Each pixel's lightness over that of the paper around it; channel: the lightest or the darkest of its three colours. */
function overPaper({ data, width, height }: Raster, channel: Channel): Float32Array {
  const pick = channel === "lightest" ? Math.max : Math.min;
  const light = new Float32Array(width * height);
  for (let k = 0; k < light.length; k++) light[k] = pick(data[4 * k]!, data[4 * k + 1]!, data[4 * k + 2]!);
  const block = Math.max(4, Math.round(Math.max(width, height) / BLOCKS));
  const [columns, rows] = [Math.ceil(width / block), Math.ceil(height / block)];
  const bright = new Float32Array(columns * rows);
  for (let k = 0; k < bright.length; k++) bright[k] = brightOf(light, width, height, (k % columns) * block, Math.floor(k / columns) * block, block);
  const paper = blurred(lightestAround(bright, columns, rows, REACH), columns, rows);
  const at = (value: number, last: number) => {
    const place = Math.min(last, Math.max(0, (value + 0.5) / block - 0.5));
    const first = Math.min(Math.floor(place), Math.max(0, last - 1));
    return [first, Math.min(first + 1, last), place - first] as const;
  };
  for (let y = 0; y < height; y++) {
    const [r0, r1, v] = at(y, rows - 1);
    for (let x = 0; x < width; x++) {
      const [c0, c1, u] = at(x, columns - 1);
      const top = paper[r0 * columns + c0]! * (1 - u) + paper[r0 * columns + c1]! * u;
      const bottom = paper[r1 * columns + c0]! * (1 - u) + paper[r1 * columns + c1]! * u;
      light[y * width + x] = light[y * width + x]! / Math.max(1, top * (1 - v) + bottom * v);
    }
  }
  return light;
}

function brightOf(light: Float32Array, width: number, height: number, left: number, top: number, block: number): number {
  const values = new Float32Array((Math.min(height, top + block) - top) * (Math.min(width, left + block) - left));
  let count = 0;
  for (let y = top; y < Math.min(height, top + block); y++) for (let x = left; x < Math.min(width, left + block); x++) values[count++] = light[y * width + x]!;
  values.sort();
  return values[Math.floor((values.length - 1) * PAPER_QUANTILE)]!;
}

function lightestAround(values: Float32Array, columns: number, rows: number, reach: number): Float32Array {
  return values.map((_, k) => {
    const [c, r] = [k % columns, Math.floor(k / columns)];
    let most = 0;
    for (let y = Math.max(0, r - reach); y <= Math.min(rows - 1, r + reach); y++)
      for (let x = Math.max(0, c - reach); x <= Math.min(columns - 1, c + reach); x++) most = Math.max(most, values[y * columns + x]!);
    return most;
  });
}

function blurred(values: Float32Array, columns: number, rows: number): Float32Array {
  return values.map((_, k) => {
    const [c, r] = [k % columns, Math.floor(k / columns)];
    let [sum, count] = [0, 0];
    for (let y = Math.max(0, r - 2); y <= Math.min(rows - 1, r + 2); y++)
      for (let x = Math.max(0, c - 2); x <= Math.min(columns - 1, c + 2); x++) [sum, count] = [sum + values[y * columns + x]!, count + 1];
    return sum / count;
  });
}

/** The value that divides dark from light best (Otsu), of values from 0 to about 1. */
export function valley(share: Float32Array): number {
  const bins = 64;
  const histogram = new Float64Array(bins);
  for (const value of share) histogram[Math.min(bins - 1, Math.floor(value * bins))]! += 1;
  const total = share.length;
  const all = histogram.reduce((sum, count, k) => sum + count * k, 0);
  let [best, where, count, sum] = [-1, 0, 0, 0];
  for (let k = 0; k < bins - 1; k++) {
    count += histogram[k]!;
    sum += histogram[k]! * k;
    if (!count || count === total) continue;
    const apart = sum / count - (all - sum) / (total - count);
    const between = count * (total - count) * apart * apart;
    if (between > best) [best, where] = [between, k + 1];
  }
  return where / bins;
}

/** The parts of a mask whose pixels touch, diagonally too; dust is left out. */
export function partsOf({ on, width, height }: Mask): InkParts {
  const numbers = new Int32Array(on.length);
  const parts: InkPart[] = [];
  const least = SPECK * on.length;
  const stack: number[] = [];
  for (let start = 0; start < on.length; start++) {
    if (!on[start] || numbers[start]) continue;
    const number = parts.length + 1;
    const part: InkPart = { number, count: 0, x0: width, y0: height, x1: 0, y1: 0 };
    const members: number[] = [];
    numbers[start] = number;
    stack.push(start);
    while (stack.length) {
      const k = stack.pop()!;
      members.push(k);
      const [x, y] = [k % width, Math.floor(k / width)];
      part.x0 = Math.min(part.x0, x);
      part.x1 = Math.max(part.x1, x);
      part.y0 = Math.min(part.y0, y);
      part.y1 = Math.max(part.y1, y);
      for (let v = Math.max(0, y - 1); v <= Math.min(height - 1, y + 1); v++)
        for (let u = Math.max(0, x - 1); u <= Math.min(width - 1, x + 1); u++) {
          const next = v * width + u;
          if (on[next] && !numbers[next]) {
            numbers[next] = number;
            stack.push(next);
          }
        }
    }
    part.count = members.length;
    if (part.count >= least) parts.push(part);
    else for (const k of members) numbers[k] = -1; // dust: visited, and of no part
  }
  return { numbers, width, height, parts };
}

/** The box around parts; null around none. */
export function boxOf(parts: readonly Box[]): Box | null {
  if (!parts.length) return null;
  return {
    x0: Math.min(...parts.map((p) => p.x0)),
    y0: Math.min(...parts.map((p) => p.y0)),
    x1: Math.max(...parts.map((p) => p.x1)),
    y1: Math.max(...parts.map((p) => p.y1)),
  };
}

/** A mask without what is narrower than `width` pixels. */
export function withoutThin(mask: Mask, width: number): Mask {
  const reach = Math.ceil(width / 2);
  const negative = (one: Mask): Mask => ({ ...one, on: one.on.map((value) => 1 - value) });
  const eroded = negative(widened(negative(mask), reach, reach));
  const opened = widened(eroded, reach, reach);
  return { ...mask, on: opened.on.map((value, k) => value & mask.on[k]!) };
}

/** A mask with every pixel widened to a rectangle. */
export function widened({ on, width, height }: Mask, across: number, down: number): Mask {
  const once = (from: Uint8Array, lines: number, length: number, stride: number, step: number, reach: number) => {
    const to = new Uint8Array(from.length);
    for (let line = 0; line < lines; line++) {
      let last = -reach - 1; // the pixel on this line that was set last
      let next = -1;
      for (let k = 0; k < length; k++) {
        if (next < k) {
          next = k;
          while (next < length && !from[line * stride + next * step]) next++;
        }
        if (from[line * stride + k * step]) last = k;
        if (k - last <= reach || (next < length && next - k <= reach)) to[line * stride + k * step] = 1;
      }
    }
    return to;
  };
  const wide = across ? once(on, height, width, width, 1, across) : on;
  return { on: down ? once(wide, width, height, 1, width, down) : wide, width, height };
}
