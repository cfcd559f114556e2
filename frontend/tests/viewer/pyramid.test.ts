import { PerspectiveCamera } from "three";
import { describe, expect, it } from "vitest";
import { FIELD_OF_VIEW } from "../../src/viewer/camera";
import { visiblePart } from "../../src/viewer/detail";
import { drawingOrder, neededTiles, readPyramid, sharpFactor, tilesOver } from "../../src/viewer/pyramid";

const info = { width: 16000, height: 7500, tiles: [{ width: 512, scaleFactors: [1, 2, 4, 8, 16, 32] }], preferredFormats: ["png"] };
const pyramid = readPyramid("/iiif/tiles/normals/a", "7", info);
const WHOLE = { left: 0, top: 0, right: 1, bottom: 1 };
const PLENTY = 1e12;

describe("the level of tiles", () => {
  it("has a pixel for almost every pixel of the screen, and not twice as many each way", () => {
    for (const across of [500, 900, 1000, 1300, 4000, 15000]) {
      const sharpness = pyramid.width / sharpFactor(pyramid, across) / across;
      expect(sharpness).toBeGreaterThanOrEqual(0.8);
      expect(sharpness).toBeLessThan(1.6);
    }
  });

  it("is the finest where one looks nearer than the pixels of the work", () => {
    expect(sharpFactor(pyramid, 100_000)).toBe(1);
  });

  it("is the coarsest where the work is small on the screen", () => {
    expect(sharpFactor(pyramid, 100)).toBe(32);
  });
});

describe("tiles", () => {
  it("cover the whole sheet without overlapping", () => {
    for (const factor of pyramid.factors) {
      const tiles = tilesOver(pyramid, factor, WHOLE);
      const area = tiles.reduce((sum, { area: { left, top, right, bottom } }) => sum + (right - left) * (bottom - top), 0);
      expect(area).toBeCloseTo(1, 9);
      expect(tiles).toHaveLength(Math.ceil(16000 / 512 / factor) * Math.ceil(7500 / 512 / factor));
    }
  });

  it("have the address of the Image API, also at the edge", () => {
    const [corner] = tilesOver(pyramid, 4, { left: 0.999, top: 0.999, right: 1, bottom: 1 });
    expect(corner!.url).toBe("/iiif/tiles/normals/a/14336,6144,1664,1356/416,339/0/default.png?v=7");
    expect(corner!.bytes).toBe(416 * 339 * 4);
    expect(corner!.area.right).toBe(1);
  });

  it("come from the middle of the view outwards, and none from beyond the sheet", () => {
    const tiles = tilesOver(pyramid, 1, { left: 0.4, top: 0.4, right: 0.6, bottom: 0.6 });
    const away = tiles.map(({ area }) => Math.hypot((area.left + area.right) / 2 - 0.5, ((area.top + area.bottom) / 2 - 0.5) * (7500 / 16000)));
    expect([...away].sort((a, b) => a - b)).toEqual(away);
    expect(tilesOver(pyramid, 1, { left: 1.2, top: 0, right: 1.4, bottom: 1 })).toEqual([]);
    expect(tilesOver(pyramid, 32, { left: -3, top: -3, right: 4, bottom: 4 })).toHaveLength(1);
  });

  it("are preceded by a few coarse ones", () => {
    const { sharp, coarse } = neededTiles(pyramid, { left: 0.4, top: 0.4, right: 0.5, bottom: 0.5 }, 16000, PLENTY);
    expect(sharp[0]!.factor).toBe(1);
    expect(coarse[0]!.factor).toBe(4);
    expect(coarse.length).toBeLessThan(sharp.length);
  });

  it("become coarser rather than take more memory than there is", () => {
    const all = neededTiles(pyramid, WHOLE, 16000, PLENTY).sharp;
    const few = neededTiles(pyramid, WHOLE, 16000, 20e6).sharp;
    expect(all[0]!.factor).toBe(1);
    expect(few.reduce((sum, { bytes }) => sum + bytes, 0)).toBeLessThanOrEqual(20e6);
  });

  it("are drawn with those wanted on top", () => {
    const order = drawingOrder([{ factor: 1 }, { factor: 2 }, { factor: 8 }, { factor: 4 }], 2);
    expect(order.map(({ factor }) => factor)).toEqual([8, 4, 1, 2]);
  });
});

it("an info.json without tiles is refused", () => {
  expect(() => readPyramid("/iiif/x", "1", { width: 10, height: 10 })).toThrow("/iiif/x");
});

describe("what a camera sees", () => {
  const sheet = { wide: 1, tall: 0.5 };
  function looking(position: [number, number, number], target: [number, number, number]) {
    const camera = new PerspectiveCamera(FIELD_OF_VIEW, 2, 0.01, 30);
    camera.position.set(...position);
    camera.lookAt(...target);
    camera.updateMatrixWorld();
    return visiblePart(camera, sheet);
  }

  it("straight on is its whole picture, of which each pixel is one of the screen", () => {
    const tall = 2 * Math.tan(((FIELD_OF_VIEW / 2) * Math.PI) / 180) * 0.2;
    const part = looking([0.1, -0.05, 0.2], [0.1, -0.05, 0]);
    expect(part.left).toBeCloseTo(0.6 - tall, 6);
    expect(part.right).toBeCloseTo(0.6 + tall, 6);
    expect(part.top).toBeCloseTo(0.6 - tall, 6);
    expect(part.bottom).toBeCloseTo(0.6 + tall, 6);
  });

  it("aslant stays near the sheet, also where it sees the horizon", () => {
    const part = looking([0, -2, 0.2], [0, 0, 0]);
    expect(Math.min(...Object.values(part))).toBeGreaterThan(-0.1);
    expect(Math.max(...Object.values(part))).toBeLessThan(1.1);
    expect(part.right).toBeGreaterThan(part.left);
  });
});
