// Tiles in memory: loaded in order, a few at a time, given up when they are no longer wanted; the least recently used go first.

import type { Tile } from "./pyramid";

export type TileSource<T> = {
  load: (url: string, signal: AbortSignal) => Promise<T>;
  free: (value: T) => void;
  /** Called when a tile has come, or failed. */
  onChange: () => void;
};

const AT_A_TIME = 6;
const MAX_FAILURES = 2;

export class TileCache<T> {
  private readonly loaded = new Map<string, { value: T; tile: Tile }>(); // the least recently used first
  private readonly loading = new Map<string, AbortController>();
  private readonly failures = new Map<string, number>();
  private wanted: Tile[] = [];
  bytes = 0;
  /** How often tiles have come or gone. */
  changes = 0;

  constructor(
    public maxBytes: number,
    private readonly source: TileSource<T>,
  ) {}

  /** Tiles that are in memory, in no particular order. */
  get all(): Iterable<{ value: T; tile: Tile }> {
    return this.loaded.values();
  }

  /** The tile if it is there; it counts as used. */
  use(tile: Tile): T | null {
    const found = this.loaded.get(tile.url);
    if (!found) return null;
    this.loaded.delete(tile.url);
    this.loaded.set(tile.url, found);
    return found.value;
  }

  /** How many of these tiles are still to come; those that cannot be had do not count. */
  missing(tiles: Tile[]): number {
    return tiles.filter(({ url }) => !this.loaded.has(url) && !this.hasFailed(url)).length;
  }

  /** Loads these tiles in this order, and nothing else any more. */
  want(tiles: Tile[]): void {
    this.wanted = tiles;
    const urls = new Set(tiles.map((tile) => tile.url));
    for (const [url, controller] of this.loading) {
      if (urls.has(url)) continue;
      controller.abort();
      this.loading.delete(url);
    }
    this.startLoading();
  }

  /** Gives up what is loading, and frees what is loaded. */
  clear(): void {
    this.want([]);
    this.loaded.forEach(({ value }) => this.source.free(value));
    this.loaded.clear();
    this.changes++;
    this.bytes = 0;
  }

  private hasFailed(url: string): boolean {
    return (this.failures.get(url) ?? 0) >= MAX_FAILURES;
  }

  private startLoading(): void {
    for (const tile of this.wanted) {
      if (this.loading.size >= AT_A_TIME) return;
      if (!this.loaded.has(tile.url) && !this.loading.has(tile.url) && !this.hasFailed(tile.url)) void this.load(tile);
    }
  }

  private async load(tile: Tile): Promise<void> {
    const controller = new AbortController();
    this.loading.set(tile.url, controller);
    try {
      const value = await this.source.load(tile.url, controller.signal);
      if (controller.signal.aborted) return this.source.free(value);
      this.loaded.set(tile.url, { value, tile });
      this.bytes += tile.bytes;
      this.changes++;
      this.removeUnused();
    } catch {
      if (controller.signal.aborted) return;
      this.failures.set(tile.url, (this.failures.get(tile.url) ?? 0) + 1);
    }
    this.loading.delete(tile.url);
    this.startLoading();
    this.source.onChange();
  }

  private removeUnused(): void {
    const wanted = new Set(this.wanted.map((tile) => tile.url));
    for (const [url, { value, tile }] of this.loaded) {
      if (this.bytes <= this.maxBytes) return;
      if (wanted.has(url)) continue;
      this.loaded.delete(url);
      this.bytes -= tile.bytes;
      this.source.free(value);
    }
  }
}
