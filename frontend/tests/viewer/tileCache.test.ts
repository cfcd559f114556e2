import { describe, expect, it } from "vitest";
import type { Tile } from "../../src/viewer/pyramid";
import { TileCache } from "../../src/viewer/tileCache";

const AREA = { left: 0, top: 0, right: 1, bottom: 1 };
const tile = (url: string): Tile => ({ url, factor: 1, area: AREA, bytes: 10 });
const tiles = (...urls: string[]) => urls.map(tile);
const rest = () => new Promise((resolve) => setTimeout(resolve));

/** A server that answers when told to. */
function server(maxBytes = 1000) {
  const asked: string[] = [];
  const freed: string[] = [];
  const waiting = new Map<string, { resolve: (value: string) => void; reject: (reason: Error) => void; signal: AbortSignal }>();
  let changes = 0;
  const cache = new TileCache<string>(maxBytes, {
    load: (url, signal) => {
      asked.push(url);
      return new Promise((resolve, reject) => {
        waiting.set(url, { resolve, reject, signal });
        signal.addEventListener("abort", () => reject(new Error("aborted")));
      });
    },
    free: (value) => freed.push(value),
    onChange: () => changes++,
  });
  const answer = async (...urls: string[]) => {
    for (const url of urls) waiting.get(url)!.resolve(url);
    await rest();
  };
  return { cache, asked, freed, waiting, answer, changes: () => changes };
}

describe("tiles in memory", () => {
  it("are asked for in order, a few at a time, and once", async () => {
    const { cache, asked, answer, changes } = server();
    const all = tiles("a", "b", "c", "d", "e", "f", "g", "h");
    cache.want(all);
    expect(asked).toEqual(["a", "b", "c", "d", "e", "f"]);
    cache.want(all);
    expect(asked).toHaveLength(6);
    await answer("b");
    expect(asked).toEqual(["a", "b", "c", "d", "e", "f", "g"]);
    expect(cache.use(tile("b"))).toBe("b");
    expect(cache.missing(all)).toBe(7);
    expect(changes()).toBe(1);
  });

  it("that are no longer wanted are given up", async () => {
    const { cache, asked, waiting, answer } = server();
    cache.want(tiles("a", "b"));
    cache.want(tiles("b", "c"));
    expect(waiting.get("a")!.signal.aborted).toBe(true);
    expect(waiting.get("b")!.signal.aborted).toBe(false);
    await answer("b", "c");
    expect(asked).toEqual(["a", "b", "c"]);
    expect([cache.use(tile("a")), cache.use(tile("b")), cache.bytes]).toEqual([null, "b", 20]);
  });

  it("take no more than their bytes: the least recently used go first, those in view stay", async () => {
    const { cache, freed, answer } = server(30);
    cache.want(tiles("a", "b", "c"));
    await answer("a", "b", "c");
    cache.use(tile("a"));
    cache.want(tiles("d"));
    await answer("d");
    expect(freed).toEqual(["b"]);
    expect(cache.bytes).toBe(30);
    cache.want(tiles("a", "c", "d", "e"));
    await answer("e");
    expect(cache.bytes).toBe(40);
    expect(freed).toEqual(["b"]);
  });

  it("that cannot be had are tried twice and then left out", async () => {
    const { cache, asked, waiting } = server();
    cache.want(tiles("a"));
    for (let k = 0; k < 3; k++) {
      waiting.get("a")!.reject(new Error("404"));
      await rest();
    }
    expect(asked).toEqual(["a", "a"]);
    expect(cache.missing(tiles("a"))).toBe(0);
  });

  it("are freed when they are cleared, and may be asked for again", async () => {
    const { cache, asked, freed, answer } = server();
    cache.want(tiles("a", "b"));
    await answer("a");
    cache.clear();
    await rest();
    expect([freed, cache.bytes, cache.use(tile("a"))]).toEqual([["a"], 0, null]);
    cache.want(tiles("a"));
    expect(asked).toEqual(["a", "b", "a"]);
  });
});
