import { describe, expect, it } from "vitest";
import { flatFacts } from "../../src/gallery/FlatView";
import type { Work } from "../../src/types";
import { loadHeights } from "../../src/viewer/loading";

const work = (width: number, height: number) => ({ id: "a b", width, height, files: { picture: "p.webp" } }) as unknown as Work;

describe("a work that no surface can be made of", () => {
  it("is its picture on one flat height", async () => {
    const { heights, albedo, tiles } = flatFacts(work(800, 1024));
    expect([...(await loadHeights(heights.url, heights.width * heights.height))]).toEqual([0]);
    expect([albedo, tiles]).toEqual(["p.webp", null]);
  });

  it("has tiles of its picture and none of normals where it is large", () => {
    expect(flatFacts(work(800, 1025)).tiles).toEqual({ albedo: "iiif/tiles/albedo/a%20b", normals: null, version: "" });
  });
});
