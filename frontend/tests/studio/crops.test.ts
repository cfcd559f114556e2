// The first crop of a photograph, on drawn sheets and on real copies (scripts/measure_crops.py writes those).

import { existsSync, readFileSync } from "node:fs";
import { gunzipSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { cutInk, firstCrop } from "../../src/studio/firstCrop";
import type { Raster } from "../../src/studio/photoInk";
import { onPaperAlone } from "../../src/studio/photoSheet";

type Rgb = readonly [number, number, number];
type Entry = { name: string; width: number; height: number };
const PAPER: Rgb = [244, 238, 222];
const INK: Rgb = [30, 28, 26];
const RED: Rgb = [200, 70, 60];

function sheet(width: number, height: number, colour: Rgb = PAPER): Raster {
  const data = new Uint8ClampedArray(4 * width * height);
  for (let k = 0; k < width * height; k++) data.set([...colour, 255], 4 * k);
  return { data, width, height };
}

function fill({ data, width, height }: Raster, x0: number, y0: number, x1: number, y1: number, colour: Rgb): void {
  for (let y = Math.max(0, Math.round(y0)); y < Math.min(height, Math.round(y1)); y++)
    for (let x = Math.max(0, Math.round(x0)); x < Math.min(width, Math.round(x1)); x++) data.set([...colour, 255], 4 * (y * width + x));
}

/** A cross with a dot, `side` pixels high and wide. */
function character(raster: Raster, x: number, y: number, side: number, colour: Rgb = INK, thick = 0.12): void {
  fill(raster, x, y + side * (0.5 - thick / 2), x + side, y + side * (0.5 + thick / 2), colour);
  fill(raster, x + side * (0.5 - thick / 2), y, x + side * (0.5 + thick / 2), y + side, colour);
  fill(raster, x + side * 0.75, y + side * 0.1, x + side * 0.9, y + side * 0.25, colour);
}

/** A 田字格: a frame with a cross inside. */
function grid(raster: Raster, x: number, y: number, side: number, colour: Rgb, thick = 3): void {
  for (const share of [0, 0.5, 1]) {
    const width = share === 0.5 ? Math.max(1, thick - 1) : thick;
    fill(raster, x, y + share * side - width / 2, x + side, y + share * side + width / 2, colour);
    fill(raster, x + share * side - width / 2, y, x + share * side + width / 2, y + side, colour);
  }
}

const apart = (found: { x: number; y: number; side: number }, wanted: readonly [number, number, number]): number =>
  Math.max(Math.abs(found.x - wanted[0]), Math.abs(found.y - wanted[1]), Math.abs(found.side - wanted[2]));

describe("the first crop", () => {
  for (const [name, colour] of [["red", RED], ["black", INK]] as const)
    it(`lies on a cell printed in ${name}`, () => {
      const raster = sheet(380, 500);
      grid(raster, 60, 120, 260, colour);
      character(raster, 110, 175, 150);
      const { square, reason, ink } = firstCrop(raster, null);
      expect(reason).toBe("grid");
      expect(apart(square, [60, 120, 260])).toBeLessThan(5);
      expect(cutInk(ink, square)).toEqual([]);
    });

  it("lies on the middle one of many cells", () => {
    const raster = sheet(480, 480);
    for (const row of [0, 1, 2])
      for (const column of [0, 1, 2]) {
        fill(raster, 30 + column * 140 - 1, 30, 30 + column * 140 + 1, 450, RED);
        fill(raster, 30, 30 + row * 140 - 1, 450, 30 + row * 140 + 1, RED);
        character(raster, 55 + column * 140, 60 + row * 140, 85);
      }
    fill(raster, 449, 30, 451, 450, RED);
    fill(raster, 30, 449, 450, 451, RED);
    const { square, reason } = firstCrop(raster, null);
    expect(reason).toBe("grid");
    expect(apart(square, [170, 170, 140])).toBeLessThan(5);
  });

  it("keeps a stroke that leaves its cell", () => {
    const raster = sheet(400, 400);
    grid(raster, 80, 80, 240, RED);
    character(raster, 100, 110, 150);
    fill(raster, 250, 180, 330, 192, INK); // from the middle stroke over the frame
    const { square, ink } = firstCrop(raster, null);
    expect(cutInk(ink, square)).toEqual([]);
    expect(square.side).toBeGreaterThan(240);
    expect(square.side).toBeLessThan(275);
  });

  it("is the picture where the picture is a cell", () => {
    const raster = sheet(400, 400);
    character(raster, 2, 30, 396);
    expect(firstCrop(raster, null)).toMatchObject({ reason: "picture", square: { x: 0, y: 0, side: 400 } });
  });

  it("does not take a written frame for a printed one", () => {
    const raster = sheet(400, 400);
    for (const [x, y] of [[60, 60], [332, 60]] as const) fill(raster, x, y, x + 8, 340, INK);
    for (const y of [60, 332]) fill(raster, 60, y, 340, y + 8, INK);
    for (const y of [140, 200, 260]) fill(raster, 120, y, 280, y + 8, INK);
    expect(firstCrop(raster, null).reason).toBe("picture");
  });

  it("gives writing on a bare sheet the master's size and place", () => {
    const raster = sheet(360, 500);
    character(raster, 80, 200, 150);
    const master = { x0: 0.2, y0: 0.1, x1: 0.8, y1: 0.7 };
    const { square, reason } = firstCrop(raster, master);
    expect(reason).toBe("ink");
    expect(apart(square, [80 - 50, 200 - 25, 250])).toBeLessThan(3);
  });

  it("surrounds writing as broad as the photograph", () => {
    const raster = sheet(300, 460);
    character(raster, 4, 100, 292);
    const { square, ink } = firstCrop(raster, { x0: 0, y0: 0, x1: 1, y1: 1 });
    expect(cutInk(ink, square)).toEqual([]);
    expect(square.x).toBeLessThan(-3); // the picture is continued by paper
  });

  it("finds ink in a shade, and in a colour", () => {
    const shaded = sheet(360, 500);
    character(shaded, 80, 200, 150);
    for (let k = 0; k < 360 * 500; k++) for (let c = 0; c < 3; c++) shaded.data[4 * k + c]! *= 1 - (0.6 * (k % 360)) / 360;
    const coloured = sheet(360, 500);
    character(coloured, 80, 200, 150, [220, 20, 20]);
    for (const raster of [shaded, coloured]) {
      const { square } = firstCrop(raster, { x0: 0.2, y0: 0.1, x1: 0.8, y1: 0.7 });
      expect(apart(square, [30, 175, 250])).toBeLessThan(6);
    }
  });
});

describe("a table around the sheet", () => {
  const FELT: Rgb = [70, 52, 40];
  /** A sheet 300 wide and 400 high on a table, its upper left corner at (40, 50), leaning by `lean` over its height. */
  const onTable = (draw: (raster: Raster) => void, lean = 0): Raster => {
    const raster = sheet(380, 500);
    draw(raster);
    for (let y = 0; y < 500; y++) {
      const left = 40 + (lean * (y - 50)) / 400;
      const [from, to] = y < 50 || y >= 450 ? [380, 380] : [left, left + 300];
      fill(raster, 0, y, from, y + 1, FELT);
      fill(raster, to, y, 380, y + 1, FELT);
    }
    return raster;
  };
  const master = { x0: 0.2, y0: 0.1, x1: 0.8, y1: 0.7 };

  for (const lean of [0, 25])
    it(`is no ink, with the sheet leaning by ${lean} pixels`, () => {
      const { square, reason, ink } = firstCrop(onTable((raster) => character(raster, 120, 180, 150), lean), master);
      expect(reason).toBe("ink");
      expect(apart(square, [120 - 50, 180 - 25, 250])).toBeLessThan(3);
      expect(ink.parts.length).toBe(2); // the cross and its dot
    });

  it("leaves the printed cell to be found", () => {
    const drawn = (raster: Raster) => (grid(raster, 70, 100, 240, RED), character(raster, 110, 140, 150));
    const { square, reason } = firstCrop(onTable(drawn), null);
    expect(reason).toBe("grid");
    expect(apart(square, [70, 100, 240])).toBeLessThan(5);
  });

  it("is told from a shade, from a rubbing, and from a stroke that leaves the picture", () => {
    const shaded = sheet(380, 500);
    character(shaded, 120, 180, 150);
    for (let k = 0; k < 380 * 500; k++) if (k % 380 < 170) for (let c = 0; c < 3; c++) shaded.data[4 * k + c]! *= 0.7;
    const rubbing = sheet(380, 500, INK);
    character(rubbing, 120, 180, 150, PAPER);
    const cut = sheet(380, 500);
    fill(cut, 0, 200, 300, 240, INK);
    fill(cut, 0, 0, 150, 40, INK);
    for (const raster of [shaded, rubbing, cut]) expect(onPaperAlone(raster).data).toBe(raster.data);
  });
});

describe("ink that a crop cuts", () => {
  it("is what lies beyond the edge of parts that it cuts in two", () => {
    const raster = sheet(400, 400);
    fill(raster, 100, 100, 200, 120, INK);
    fill(raster, 300, 300, 340, 340, INK); // beside the crop
    const { ink } = firstCrop(raster, null);
    const cut = cutInk(ink, { x: 50, y: 50, side: 100 });
    expect(cut.length).toBeGreaterThan(900);
    expect(cut.length).toBeLessThanOrEqual(1000);
    expect(Math.min(...cut.map((k) => k % 400))).toBeGreaterThanOrEqual(150);
    expect(cutInk(ink, { x: 50, y: 50, side: 200 })).toEqual([]);
  });
});

const CELLS = "tests/vectors/crops.json";

describe.skipIf(!existsSync(CELLS))("on real pictures", () => {
  if (!existsSync(CELLS)) return; // vitest looks into what it skips, too
  const { cells, photographs } = JSON.parse(readFileSync(CELLS, "utf8")) as { cells: Entry[]; photographs: Entry[] };
  const bytes = new Uint8Array(gunzipSync(readFileSync("tests/vectors/crops.bin.gz")));
  let at = 0;
  const bitmaps = cells.map(({ width, height }) => {
    const start = at;
    at += Math.ceil((width * height) / 8);
    return () => Uint8Array.from({ length: width * height }, (_, k) => (bytes[start + (k >> 3)]! >> (7 - (k & 7))) & 1);
  });
  const pictures = photographs.map((entry) => {
    const start = at;
    at += 3 * entry.width * entry.height;
    const raster = sheet(entry.width, entry.height);
    for (let k = 0; k < entry.width * entry.height; k++) raster.data.set(bytes.subarray(start + 3 * k, start + 3 * k + 3), 4 * k);
    return { name: entry.name, raster };
  });

  const every = process.env["ALL_CELLS"] ? 1 : 8;
  it("cuts ink in no cell, and keeps its size", { timeout: 300_000 }, () => {
    const errors: number[] = [];
    const cutIn: string[] = [];
    for (const [k, { name, width, height }] of cells.entries()) {
      if (k % every) continue;
      const ink = bitmaps[k]!();
      const data = new Uint8ClampedArray(4 * width * height).fill(255);
      ink.forEach((on, p) => on && data.fill(0, 4 * p, 4 * p + 3));
      const { x, y, side } = firstCrop({ data, width, height }, null).square;
      if (ink.some((on, p) => on && (p % width < x || (p % width) + 1 > x + side || Math.floor(p / width) < y || Math.floor(p / width) + 1 > y + side))) cutIn.push(name);
      errors.push(Math.abs(Math.max(width, height) / side - 1));
    }
    errors.sort((a, b) => a - b);
    const percent = (value: number) => `${(100 * value).toFixed(1)} %`;
    console.log(`cells: ${errors.length}; ink cut in ${cutIn.length}; size error: median ${percent(errors[Math.floor(errors.length / 2)]!)}, largest ${percent(errors.at(-1)!)}`);
    expect(cutIn).toEqual([]);
    expect(errors.at(-1)).toBeLessThan(0.02);
  });

  it("cuts no writing in photographs, and finds their printed cells", { timeout: 300_000 }, () => {
    const found = pictures.map(({ name, raster }) => {
      const began = performance.now();
      const crop = firstCrop(raster, null);
      return { name, ...crop, cut: cutInk(crop.ink, crop.square).length, ms: performance.now() - began };
    });
    for (const { name, reason, square, cut, ms } of found) console.log(`${name}: ${reason} ${[square.x, square.y, square.side].map(Math.round).join(" ")}; cut ${cut}; ${ms.toFixed(0)} ms`);
    expect(found.filter(({ cut }) => cut).map(({ name }) => name)).toEqual([]);
    const wanted: Record<string, readonly [number, number, number]> = {
      "copy-心1.jpeg": [35, 36, 440],
      "copy-心2.jpeg": [43, 87, 289],
      "shui-grid-black.jpg": [11, 11, 490],
      "shui-grid-gray100.jpg": [11, 11, 490],
      "shui-grid-gray130.jpg": [11, 11, 490],
    };
    for (const { name, reason, square } of found) {
      const place = wanted[name];
      if (place) expect([name, reason, apart(square, place) < 5]).toEqual([name, "grid", true]);
      else if (name.startsWith("shui-")) expect([name, reason, square.side]).toEqual([name, "picture", 512]);
    }
  });
});
