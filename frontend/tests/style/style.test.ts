import { describe, expect, it } from "vitest";

const sheets = import.meta.glob<string>("../../src/**/*.css", { query: "?raw", import: "default", eager: true });

/** Classes that a sheet's selectors begin with. */
function owned(css: string): Set<string> {
  const plain = css.replace(/\/\*[^]*?\*\//g, "");
  const selectors = [...plain.matchAll(/([^{}]+)\{/g)].flatMap((found) => found[1]!.split(","));
  return new Set(selectors.map((selector) => /^\s*\.([\w-]+)/.exec(selector)?.[1]).filter((name) => name !== undefined));
}

describe("the style sheets", () => {
  it("do not reach into each other: all of them stay loaded when another page comes", () => {
    const homes = new Map<string, string[]>();
    for (const [file, css] of Object.entries(sheets)) for (const name of owned(css)) homes.set(name, [...(homes.get(name) ?? []), file]);
    expect(homes.size).toBeGreaterThan(100);
    const shared = [...homes].filter(([, files]) => files.length > 1);
    expect(shared).toEqual([]);
  });
});
