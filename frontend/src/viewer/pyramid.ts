// Which tiles of a map show a part of the sheet at the sharpness of the screen. A map is a IIIF image service of level 0.

/** Fractions of the sheet, origin top left. */
export type Part = { left: number; top: number; right: number; bottom: number };

export type Pyramid = {
  /** Address of the image service, without a last slash, and the version of its tiles; empty where it is not known. */
  service: string;
  version: string;
  suffix: string;
  width: number;
  height: number;
  /** Side of a tile in pixels. */
  side: number;
  /** Pixels of the map for one of a tile: 1, 2, 4... */
  factors: number[];
};

export type Tile = { url: string; factor: number; area: Part; bytes: number };

/** As the service's info.json says it. */
export type ImageInfo = {
  width: number;
  height: number;
  tiles?: { width: number; scaleFactors: number[] }[];
  preferredFormats?: string[];
  /** Of heights: what a level is worth. */
  heights?: { scale: number; offset: number };
};

/** What a service says of itself. */
export async function loadInfo(service: string, version: string, signal: AbortSignal): Promise<ImageInfo> {
  const response = await fetch(`${service}/info.json${versionQuery(version)}`, { signal, credentials: "same-origin" });
  if (!response.ok) throw new Error(`${service}: ${response.status}`);
  return (await response.json()) as ImageInfo;
}

const BYTES_PER_PIXEL = 4;
/** Fewest pixels of a tile for one of the screen. A little below 1, or a picture that just fills the screen would take four times as many. */
const LEAST_SHARPNESS = 0.8;

export function readPyramid(service: string, version: string, info: ImageInfo): Pyramid {
  const [tiles] = info.tiles ?? [];
  if (!tiles?.scaleFactors.length || !(info.width > 0) || !(info.height > 0)) throw new Error(`expected the tiles of ${service}, got none`);
  const factors = [...tiles.scaleFactors].sort((a, b) => a - b);
  return { service, version, suffix: info.preferredFormats?.[0] ?? "jpg", width: info.width, height: info.height, side: tiles.width, factors };
}

/** The coarsest factor that is sharp where the whole sheet would be `across` pixels of the screen wide. */
export function sharpFactor(pyramid: Pyramid, across: number): number {
  const most = pyramid.width / (across * LEAST_SHARPNESS);
  return pyramid.factors.filter((factor) => factor <= most).at(-1) ?? pyramid.factors[0]!;
}

/** The tiles of one factor over a part of the sheet, those nearest to its middle first. */
export function tilesOver(pyramid: Pyramid, factor: number, part: Part): Tile[] {
  const { width, height, side } = pyramid;
  const step = side * factor;
  const [columns, rows] = [Math.ceil(width / step), Math.ceil(height / step)];
  const first = (fraction: number, whole: number) => Math.max(0, Math.floor((fraction * whole) / step));
  const end = (fraction: number, whole: number, count: number) => Math.min(count, Math.ceil((fraction * whole) / step));
  const tiles: Tile[] = [];
  for (let row = first(part.top, height); row < end(part.bottom, height, rows); row++) {
    for (let column = first(part.left, width); column < end(part.right, width, columns); column++) {
      tiles.push(tileAt(pyramid, factor, column, row));
    }
  }
  const [x, y] = [(part.left + part.right) / 2, (part.top + part.bottom) / 2];
  const away = ({ area }: Tile) => Math.hypot(((area.left + area.right) / 2 - x) * width, ((area.top + area.bottom) / 2 - y) * height);
  return tiles.sort((a, b) => away(a) - away(b));
}

/** What is added to an address so that the browser may keep what it gives for ever. */
export const versionQuery = (version: string): string => (version ? `?v=${version}` : "");

function tileAt(pyramid: Pyramid, factor: number, column: number, row: number): Tile {
  const { width, height, side } = pyramid;
  const [x, y] = [column * side * factor, row * side * factor];
  const [w, h] = [Math.min(side * factor, width - x), Math.min(side * factor, height - y)];
  const [wide, tall] = [Math.ceil(w / factor), Math.ceil(h / factor)];
  const url = `${pyramid.service}/${x},${y},${w},${h}/${wide},${tall}/0/default.${pyramid.suffix}${versionQuery(pyramid.version)}`;
  const area = { left: x / width, top: y / height, right: (x + w) / width, bottom: (y + h) / height };
  return { url, factor, area, bytes: wide * tall * BYTES_PER_PIXEL };
}

/** What is to be loaded for a part of the sheet: sharp tiles, and before them a few coarse ones that cover it at once. */
export function neededTiles(pyramid: Pyramid, part: Part, across: number, maxBytes: number): { sharp: Tile[]; coarse: Tile[] } {
  const { factors } = pyramid;
  let at = factors.indexOf(sharpFactor(pyramid, across));
  let sharp = tilesOver(pyramid, factors[at]!, part);
  while (sharp.reduce((sum, tile) => sum + tile.bytes, 0) > maxBytes && at < factors.length - 1) sharp = tilesOver(pyramid, factors[++at]!, part);
  const coarser = factors[at + COARSER_BY];
  return { sharp, coarse: coarser === undefined ? [] : tilesOver(pyramid, coarser, part) };
}

/** Levels between sharp tiles and those that are loaded first: a sixteenth of their number. */
const COARSER_BY = 2;

/** In which order tiles are drawn: coarse ones first, then finer ones than wanted (of an earlier, nearer view), those wanted last. */
export function drawingOrder<T extends { factor: number }>(tiles: T[], wanted: number): T[] {
  const rank = ({ factor }: T) => (factor === wanted ? 2 : factor < wanted ? 1 : 0);
  return [...tiles].sort((a, b) => rank(a) - rank(b) || b.factor - a.factor);
}
