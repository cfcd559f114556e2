import { describe, expect, it } from "vitest";
import { HeightField, heightIn } from "../../src/viewer/heightfield";
import { grid, squares } from "../../src/viewer/grid";
import { compose, decodeHeights } from "../../src/viewer/nearHeights";
import { type Pyramid, tilesOver } from "../../src/viewer/pyramid";

const pyramid: Pyramid = { service: "/t", version: "", suffix: "png", width: 12, height: 6, side: 4, factors: [1, 2] };
/** Tiles of a slope that rises by 1 for each pixel to the right and by 100 for each one down. */
const tiles = (factor: number) =>
  tilesOver(pyramid, factor, { left: 0, top: 0, right: 1, bottom: 1 }).map((tile) => {
    const [x, y] = [(tile.area.left * 12) / factor, (tile.area.top * 6) / factor].map(Math.round) as [number, number];
    const [wide, tall] = [Math.ceil(((tile.area.right - tile.area.left) * 12) / factor), Math.ceil(((tile.area.bottom - tile.area.top) * 6) / factor)];
    return { tile, width: wide, values: Float32Array.from({ length: wide * tall }, (_, k) => x + (k % wide) + 100 * (y + Math.floor(k / wide))) };
  });

describe("heights of the part that is seen", () => {
  it("are levels of two bytes", () => {
    const rgba = Uint8ClampedArray.from([1, 2, 0, 255, 255, 255, 0, 255]);
    expect([...decodeHeights(rgba, { scale: 0.5, offset: -10 })]).toEqual([119, 32757.5]);
  });

  it("are put together of tiles over whole pixels", () => {
    const patch = compose(pyramid, { left: 0.3, top: 0.4, right: 0.8, bottom: 0.9 }, tiles(1));
    expect([patch.width, patch.height, patch.part.left * 12, patch.part.right * 12]).toEqual([7, 4, 3, 10]);
    expect([...patch.values.slice(0, 7)]).toEqual([203, 204, 205, 206, 207, 208, 209]);
    expect(patch.values.at(-1)).toBe(509);
    expect(heightIn(patch, 5.5 / 12, 3.5 / 6)).toBeCloseTo(305, 4);
    expect([...compose(pyramid, { left: 0, top: 0, right: 1, bottom: 1 }, tiles(2)).values.slice(0, 6)]).toEqual([0, 1, 2, 3, 4, 5]);
  });

  it("are what a point, a section and the mesh have there", () => {
    const field = new HeightField(new Float32Array(18), 6, 3, 0, 1000, { width: 12, height: 6, spacing: 1, unit: "px" });
    field.near = compose(pyramid, { left: 0.25, top: 0.5, right: 0.75, bottom: 1 }, tiles(1));
    expect(field.at(5.5 / 12, 3.5 / 6)).toBeCloseTo(305, 4);
    expect(field.at(0.9, 0.1)).toBe(0);
    const mesh = grid(field, 6, (u, v) => field.at(u, v), field.near.part);
    const [at, uv] = [mesh.getAttribute("position"), mesh.getAttribute("uv")];
    expect(squares(field, 6, field.near.part)).toEqual([6, 3]);
    expect([at.getX(0), at.getY(0), uv.getX(0), uv.getY(0)]).toEqual([-0.25, 0, 0.25, 0.5]);
  });
});
