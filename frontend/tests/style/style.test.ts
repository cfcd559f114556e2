import { describe, expect, it } from "vitest";

const sheets = import.meta.glob<string>("../../src/**/*.css", { query: "?raw", import: "default", eager: true });

/** The classes with which a style sheet's selectors begin. */
function firstClasses(css: string): Set<string> {
  const plain = css.replace(/\/\*[^]*?\*\//g, "");
  const selectors = [...plain.matchAll(/([^{}]+)\{/g)].flatMap((found) => found[1]!.split(","));
  return new Set(selectors.map((selector) => /^\s*\.([\w-]+)/.exec(selector)?.[1]).filter((name) => name !== undefined));
}

describe("the style sheets", () => {
  it("do not share classes, since all of them stay loaded when the page changes", () => {
    const filesOf = new Map<string, string[]>();
    for (const [file, css] of Object.entries(sheets)) for (const name of firstClasses(css)) filesOf.set(name, [...(filesOf.get(name) ?? []), file]);
    expect(filesOf.size).toBeGreaterThan(100);
    const shared = [...filesOf].filter(([, files]) => files.length > 1);
    expect(shared).toEqual([]);
  });
});
