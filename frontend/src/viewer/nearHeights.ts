// The heights of the part of a work that is seen from nearby, put together of tiles: those of the whole work are too few there.

import type { TileServices } from "../types";
import { loadPicture } from "./loading";
import { type ImageInfo, loadInfo, neededTiles, type Part, type Pyramid, readPyramid, type Tile } from "./pyramid";
import { TileCache } from "./tileCache";

/** Heights over a part of the sheet, row by row from the top. */
export type HeightPatch = { part: Part; width: number; height: number; values: Float32Array<ArrayBuffer> };
type Levels = { scale: number; offset: number };
type Values = { width: number; values: Float32Array };

/** Heights that are wanted along the longer side of what is seen. */
const ALONG = 512;
const MAX_BYTES = 32e6;
/** A part begins and ends at multiples of this share of its size, so that a small move keeps it. */
const STEP = 1 / 4;

export class NearHeights {
  /** How many tiles are still to come. */
  missing = 0;
  private readonly tiles: TileCache<Values>;
  private pyramid: Pyramid | null = null;
  private patch: HeightPatch | null = null;
  private asked = false;
  private awaited = false;
  private levels: Levels | null = null;

  /** size: of the sheet, where its longer side is 1. across: heights along the width of the whole. onChange: called when tiles have come. */
  constructor(
    private readonly services: TileServices,
    private readonly size: { wide: number; tall: number },
    private readonly across: number,
    private readonly onChange: () => void,
    private readonly signal: AbortSignal,
  ) {
    this.tiles = new TileCache<Values>(MAX_BYTES, { load: (url, cancelled) => this.load(url, cancelled), free: () => undefined, onChange });
  }

  /** The heights over a part, once they have come; null where those of the whole are as fine. */
  over(seen: Part): HeightPatch | null {
    const part = snapped(seen);
    const across = ALONG / Math.max(part.right - part.left, ((part.bottom - part.top) * this.size.tall) / this.size.wide);
    this.missing = 0;
    if (across <= this.across || part.right <= part.left || part.bottom <= part.top) return null;
    if (!this.asked) this.ask();
    this.missing = Number(this.awaited);
    if (!this.pyramid) return null;
    const { sharp } = neededTiles(this.pyramid, part, across, MAX_BYTES);
    this.tiles.want(sharp);
    this.missing = this.tiles.missing(sharp);
    if (this.missing) return this.patch && contains(this.patch.part, seen) ? this.patch : null;
    if (this.patch && isSame(this.patch.part, pixelPart(this.pyramid, sharp[0]!.factor, part))) return this.patch;
    const values = sharp.flatMap((tile) => {
      const found = this.tiles.use(tile);
      return found ? [{ tile, ...found }] : [];
    });
    this.patch = values.length === sharp.length ? compose(this.pyramid, part, values) : null;
    return this.patch;
  }

  private ask(): void {
    this.asked = true;
    const { heights, version } = this.services;
    if (!heights) return;
    this.awaited = true;
    const come = (info: ImageInfo | null) => {
      this.awaited = false;
      this.levels = info?.heights ?? null;
      this.pyramid = info?.heights ? readPyramid(heights, version, info) : null;
      this.onChange();
    };
    // Without them the surface stays as it is.
    loadInfo(heights, version, this.signal).then(come, () => this.signal.aborted || come(null));
  }

  private async load(url: string, signal: AbortSignal): Promise<Values> {
    const picture = await loadPicture(url, signal);
    const { width, height } = picture;
    const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true })!;
    context.drawImage(picture, 0, 0);
    picture.close();
    return { width, values: decodeHeights(context.getImageData(0, 0, width, height).data, this.levels!) };
  }
}

/** Heights of pixels whose red and green are the upper and the lower byte of a level. */
export function decodeHeights(rgba: Uint8ClampedArray, { scale, offset }: Levels): Float32Array {
  return Float32Array.from({ length: rgba.length / 4 }, (_, k) => (256 * rgba[4 * k]! + rgba[4 * k + 1]!) * scale + offset);
}

/** Puts tiles of one factor together over a part, which is widened to whole pixels. */
export function compose(pyramid: Pyramid, part: Part, tiles: (Values & { tile: Tile })[]): HeightPatch {
  const factor = tiles[0]!.tile.factor;
  const { left, top, width, height } = pixels(pyramid, factor, part);
  const values = new Float32Array(width * height);
  for (const { tile, width: wide, values: own } of tiles) {
    const x = Math.round((tile.area.left * pyramid.width) / factor) - left;
    const y = Math.round((tile.area.top * pyramid.height) / factor) - top;
    const [from, to] = [Math.max(0, x), Math.min(width, x + wide)];
    for (let row = Math.max(0, y); row < Math.min(height, y + own.length / wide); row++) {
      const at = (row - y) * wide - x;
      values.set(own.subarray(at + from, at + to), row * width + from);
    }
  }
  return { part: pixelPart(pyramid, factor, part), width, height, values };
}

/** A part in pixels of the tiles of one factor. */
function pixels(pyramid: Pyramid, factor: number, part: Part): { left: number; top: number; width: number; height: number } {
  const [across, down] = [Math.ceil(pyramid.width / factor), Math.ceil(pyramid.height / factor)];
  const [left, top] = [Math.floor((part.left * pyramid.width) / factor), Math.floor((part.top * pyramid.height) / factor)];
  const right = Math.min(across, Math.ceil((part.right * pyramid.width) / factor));
  const bottom = Math.min(down, Math.ceil((part.bottom * pyramid.height) / factor));
  return { left, top, width: right - left, height: bottom - top };
}

function pixelPart(pyramid: Pyramid, factor: number, part: Part): Part {
  const { left, top, width, height } = pixels(pyramid, factor, part);
  const [x, y] = [factor / pyramid.width, factor / pyramid.height];
  return { left: left * x, top: top * y, right: (left + width) * x, bottom: (top + height) * y };
}

/** What is seen and some more, within the sheet. */
function snapped({ left, top, right, bottom }: Part): Part {
  const step = (from: number, to: number) => 2 ** Math.ceil(Math.log2(Math.max(to - from, 1e-6))) * STEP;
  const [x, y] = [step(left, right), step(top, bottom)];
  const within = (value: number) => Math.min(1, Math.max(0, value));
  return {
    left: within(Math.floor(left / x) * x),
    top: within(Math.floor(top / y) * y),
    right: within(Math.ceil(right / x) * x),
    bottom: within(Math.ceil(bottom / y) * y),
  };
}

const contains = (outer: Part, { left, top, right, bottom }: Part): boolean =>
  outer.left <= Math.max(0, left) && outer.top <= Math.max(0, top) && outer.right >= Math.min(1, right) && outer.bottom >= Math.min(1, bottom);
const isSame = (a: Part, b: Part): boolean => a.left === b.left && a.top === b.top && a.right === b.right && a.bottom === b.bottom;
