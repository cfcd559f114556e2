// The viewer's arithmetic, compared with reference values from Python (scripts/write_vectors.py).

import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { contourDistance, decodeNormal, heightColour, lambert, lampDirection, linearToSrgb, mixPhotographs, mixtureWeights, srgbToLinear, type Vec3 } from "../../src/viewer/shading";
import { roundLevels } from "../../src/viewer/scales";
import { HeightField } from "../../src/viewer/heightfield";

type Vectors = {
  srgb: { linear: number[]; codes: number[] };
  normals: { bytes: Vec3[]; normals: Vec3[] };
  relight: { side: number; albedo: Vec3[]; normals: Vec3[]; lamps: [number, number][]; lit: Vec3[][] };
  three: { slant: number; lamps: [number, number][]; mixed: number[][]; a: number[]; b: number[]; c: number[] };
  colours: { at: number[]; rgb: Vec3[] };
  contours: { ranges: [number, number, number, number[]][]; heights: number[]; interval: number; distance: number[] };
  section: { heights: number[]; size: [number, number]; spacing: number; line: [number, number, number, number]; distance: number[]; sampled: number[] };
};

// Without the file the tests fail; `python scripts/write_vectors.py` writes it.
const given = JSON.parse(readFileSync("tests/vectors/viewer.json", "utf8")) as Vectors;

/** The largest difference between two lists of numbers. */
const apart = (found: number[], wanted: number[]): number => {
  expect(found.length).toBe(wanted.length);
  return Math.max(...found.map((value, k) => Math.abs(value - wanted[k]!)));
};

describe("arithmetic, compared with rumu", () => {
  it("encodes and decodes sRGB", () => {
    const codes = given.srgb.linear.map((value) => linearToSrgb(value) * 65535);
    expect(apart(codes, given.srgb.codes)).toBeLessThan(1);
    expect(apart(given.srgb.codes.map((code) => srgbToLinear(code / 65535)), given.srgb.linear)).toBeLessThan(1e-4);
  });

  it("reads normals from bytes to within their rounding", () => {
    const found = given.normals.bytes.map(([x, y, z]) => decodeNormal([x / 255, y / 255, z / 255]));
    expect(apart(found.flat(), given.normals.normals.flat())).toBeLessThan(0.007);
  });

  it("relights as rumu.relight", () => {
    const { albedo, normals, lamps, lit: wanted } = given.relight;
    for (const [k, [tilt, slant]] of lamps.entries()) {
      const found = albedo.map((a, at) => lambert(a, normals[at]!, lampDirection(tilt, slant)));
      expect(apart(found.flat(), wanted[k]!.flat())).toBeLessThan(2e-6);
    }
  });

  it("mixes three photographs as the paper does", () => {
    const { a, b, c, slant, lamps, mixed: wanted } = given.three;
    for (const [k, [tilt, fresh]] of lamps.entries()) {
      const weights = mixtureWeights(tilt, fresh, slant);
      expect(apart(a.map((value, at) => mixPhotographs(value, b[at]!, c[at]!, weights)), wanted[k]!)).toBeLessThan(2e-6);
    }
  });

  it("colours heights by viridis", () => {
    expect(apart(given.colours.at.flatMap(heightColour), given.colours.rgb.flat())).toBeLessThan(2 / 255);
  });

  it("finds contour lines", () => {
    for (const [low, high, count, wanted] of given.contours.ranges) expect(apart(roundLevels(low, high, count), wanted)).toBeLessThan(1e-9);
    const { heights, interval, distance } = given.contours;
    expect(apart(heights.map((height) => contourDistance(height, interval)), distance)).toBeLessThan(1e-9);
  });

  it("samples a cross-section as scipy does", () => {
    const { heights, size: [width, height], spacing, line, distance, sampled } = given.section;
    const field = new HeightField(Float32Array.from(heights), width, height, -5, 5, { width, height, spacing, unit: "mm" });
    const found = field.section(line, distance.length);
    expect(apart(found.map((p) => p.distance), distance)).toBeLessThan(1e-6);
    expect(apart(found.map((p) => p.height), sampled)).toBeLessThan(1e-6);
  });
});

describe("a raised dome", () => {
  const { side, albedo, normals } = given.relight;
  const around = (row: number, column: number) => normals[row * side + column]!;

  it("is brighter on the lamp's side, the upper left", () => {
    const light = lampDirection(135, 45);
    const [quarter, far] = [Math.round(side * 0.35), Math.round(side * 0.65)];
    const grey: Vec3 = [0.5, 0.5, 0.5];
    expect(lambert(grey, around(quarter, quarter), light)[0]).toBeGreaterThan(1.5 * lambert(grey, around(far, far), light)[0]);
    expect(albedo.length).toBe(side * side);
  });
});
