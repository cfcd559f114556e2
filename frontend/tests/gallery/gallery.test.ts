import { describe, expect, it } from "vitest";
import { readFilters, without, writeFilters } from "../../src/gallery/listState";
import { type CardImage, shadePixels } from "../../src/gallery/relighting";
import { licenceName, messageInOneLanguage, withoutNumber } from "../../src/gallery/labels";
import { language } from "../../src/i18n";
import { lampDirection } from "../../src/viewer/shading";

describe("filters in the address", () => {
  it("survive a round trip", () => {
    const filters = { script: "regular", hand: "顏真卿", q: "天 地" };
    expect(readFilters(new URLSearchParams(writeFilters(filters).toString()))).toEqual(filters);
  });

  it("ignore empty and unknown values", () => {
    expect(readFilters(new URLSearchParams("script=&colour=red&q=%20"))).toEqual({});
    expect(writeFilters(without({ q: "a", script: "seal" }, "q")).toString()).toBe("script=seal");
  });
});

describe("labels", () => {
  it("lose a number of their own in a numbered list", () => {
    expect(["1. The upright", "一、豎", "12) Last", "一個水", "3 steles", "2."].map(withoutNumber)).toEqual(["The upright", "豎", "Last", "一個水", "3 steles", "2."]);
  });

  it("are in one language, though the service sends both", () => {
    language.value = "zh";
    expect([messageInOneLanguage("重建表面 Reconstructing"), licenceName("none stated"), licenceName("CC0-1.0")]).toEqual(["重建表面", "未註明", "CC0-1.0"]);
    language.value = "en";
    expect([messageInOneLanguage("重建表面 Reconstructing"), messageInOneLanguage("plain words"), licenceName("none stated")]).toEqual(["Reconstructing", "plain words", "none stated"]);
  });
});

describe("a relit card", () => {
  const slope = Math.SQRT1_2;
  // White paper, then dark ink sloping to the left, then dark ink sloping to the right.
  const card: CardImage = {
    width: 3,
    height: 1,
    linear: Float32Array.from([1, 1, 1, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02]),
    normals: Float32Array.from([0, 0, 1, -slope, 0, slope, slope, 0, slope]),
  };
  const under = (tilt: number, slant: number, sheen?: number) => {
    const out = new Uint8ClampedArray(12);
    shadePixels(card, lampDirection(tilt, slant), out, sheen);
    return [out[0]!, out[4]!, out[8]!];
  };

  it("shines on the slope that faces the lamp", () => {
    const [, left, right] = under(180, 50);
    expect(left).toBeGreaterThan(right! + 40);
    const [, leftAgain, rightAgain] = under(0, 50);
    expect(rightAgain).toBe(left);
    expect(leftAgain).toBe(right);
  });

  it("keeps paper light, and measured ink matt", () => {
    expect(under(90, 0)[0]).toBe(255);
    expect(under(90, 60)[0]).toBeGreaterThan(190);
    const [, glossy] = under(180, 50);
    const [, matt] = under(180, 50, 0);
    expect(matt).toBeLessThan(glossy! - 40);
  });
});
