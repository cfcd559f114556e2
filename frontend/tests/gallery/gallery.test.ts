import { describe, expect, it } from "vitest";
import { readFilters, without, writeFilters } from "../../src/gallery/listState";
import { type CardImage, shadePixels } from "../../src/gallery/relighting";
import { messageInOneLanguage, withoutNumber } from "../../src/gallery/labels";
import { licenceName, licenceParts, translated } from "../../src/gallery/licences";
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
    expect([messageInOneLanguage("重建表面 Reconstructing"), licenceName("none stated")]).toEqual(["重建表面", "未註明"]);
    language.value = "en";
    expect([messageInOneLanguage("重建表面 Reconstructing"), messageInOneLanguage("plain words"), licenceName("none stated")]).toEqual(["Reconstructing", "plain words", "none stated"]);
  });
});

describe("a licence", () => {
  const cases: [written: string, zh: string, en: string, path: string | null][] = [
    ["CC-BY-4.0", "CC BY 4.0　姓名標示", "CC BY 4.0, Attribution", "licenses/by/4.0/"],
    ["CC BY-SA 3.0", "CC BY-SA 3.0　姓名標示-相同方式分享", "CC BY-SA 3.0, Attribution-ShareAlike", "licenses/by-sa/3.0/"],
    ["cc by nc nd 4.0", "CC BY-NC-ND 4.0　姓名標示-非商業性-禁止改作", "CC BY-NC-ND 4.0, Attribution-NonCommercial-NoDerivatives", "licenses/by-nc-nd/4.0/"],
    ["CC-BY-ND-3.0-TW", "CC BY-ND 3.0　姓名標示-禁止改作　臺灣", "CC BY-ND 3.0, Attribution-NoDerivatives, Taiwan", "licenses/by-nd/3.0/tw/"],
    ["https://creativecommons.org/licenses/by-nc/4.0/", "CC BY-NC 4.0　姓名標示-非商業性", "CC BY-NC 4.0, Attribution-NonCommercial", "licenses/by-nc/4.0/"],
    ["CC0-1.0", "CC0 1.0　公眾領域貢獻宣告", "CC0 1.0, Public Domain Dedication", "publicdomain/zero/1.0/"],
    ["公有領域", "公有領域", "public domain", null],
    ["public domain (as declared by the author)", "公有領域（作者聲明）", "public domain (as declared by the author)", null],
    ["none stated", "未註明", "none stated", null],
    ["CC-BY-XX-4.0", "CC-BY-XX-4.0", "CC-BY-XX-4.0", null],
    ["the museum's own terms", "the museum's own terms", "the museum's own terms", null],
  ];
  for (const [written, zh, en, path] of cases)
    it(`is told in both languages: ${written}`, () => {
      for (const [now, name, deed] of [["zh", zh, "deed.zh-hant"], ["en", en, "deed.en"]] as const) {
        language.value = now;
        expect(licenceName(written)).toBe(name);
        if (path) expect(licenceParts(written).url).toBe(`https://creativecommons.org/${path}${deed}`);
      }
    });

  it("has a text to read where the service knows one", () => {
    language.value = "zh";
    expect(licenceParts("OFL-1.1 (the font; a picture made with it is free)")).toEqual({ name: "SIL 開放字型授權 1.1", url: "https://openfontlicense.org", rest: "指字型；用它作的圖不受限" });
    expect(translated("青柳衡山 (Kouzan Aoyagi); copyright waived by the author")).toBe("青柳衡山 (Kouzan Aoyagi); 作者放棄著作權");
    language.value = "en";
    expect(translated("shown unchanged")).toBe("shown unchanged");
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
