// A viewer in a page: a scene, its state, and what pointer and keys do to it. Buttons and plots around it are in ViewerPanel.tsx.

import { Vector3 } from "three";
import type { TileServices, ViewerFacts } from "../types";
import { type Action, listenForInput } from "./controls";
import { SHEEN } from "./shading";
import { HeightField, type ProfilePoint } from "./heightfield";
import { loadHeights, loadPicture } from "./loading";
import { enterSession } from "./webxr";
import { type Camera, DEFAULT_VIEW, lightAt, normalizeView, type SheetLine, type ViewState } from "./state";
import { interpolateCamera, orbit, pan, zoom } from "./camera";
import { createPictureViewer, hasWebGL2 } from "./fallback";
import { type LensPosition, SheetScene } from "./scene";
import type { SessionMode, SheetPoint, Tool, Viewer, ViewerOptions } from "./types";
import "./viewer.css"; // imported here, so that a viewer has its size in any page

const SHARED = ["mode", "tilt", "slant", "exaggeration", "camera", "look"] as const;
const KEY_STEP = 5;
/** How far an arrow key moves the picture, as a share of its height. */
const PAN_STEP = 0.15;
const LENS_RADIUS = 90;
/** True while one viewer passes a change to the other, which must not pass it back. */
let syncing = false;

/** Creates a viewer in `host`; without WebGL2 the picture and a message. Rejects when a file cannot be read. */
export async function createViewer(host: HTMLElement, facts: ViewerFacts, options: ViewerOptions = {}): Promise<Viewer> {
  if (!hasWebGL2()) return createPictureViewer(host, facts);
  const { signal } = options;
  const lamps = facts.three_lamps;
  const measured = facts.source === "photometric";
  const [values, albedo, normals, photo, mask, three] = await Promise.all([
    loadHeights(facts.heights.url, facts.heights.width * facts.heights.height, signal),
    loadPicture(facts.albedo, signal),
    loadPicture(facts.normals, signal),
    measured ? loadPicture(facts.picture, signal) : null, // else the albedo is the picture
    measured ? loadPicture(facts.mask, signal) : null,
    lamps && Promise.all([lamps.a, lamps.b, lamps.c].map((url) => loadPicture(url, signal))),
  ]);
  signal?.throwIfAborted();
  const [a, b, c] = three ?? [];
  const maps = { albedo, normals, photo, mask, lamps: lamps && a && b && c ? { a, b, c, slant: lamps.slant } : null };
  return new SheetViewer(host, facts, HeightField.from(facts, values), maps, options);
}

class SheetViewer implements Viewer {
  readonly canvas = document.createElement("canvas");
  state: ViewState;
  tool: Tool = "light";
  private readonly scene: SheetScene;
  private readonly listeners = new Set<() => void>();
  private readonly cleanups: (() => void)[] = [];
  private other: Viewer | null = null;
  private frame = 0;
  /** Width, height and pixels for a CSS pixel, as they are drawn. */
  private size = "";
  private animation = 0;
  private lens: { x: number; y: number } | null = null;
  private drawn: { line: "section" | "ruler"; from: { x: number; y: number } } | null = null;

  constructor(
    private readonly host: HTMLElement,
    readonly facts: ViewerFacts,
    readonly field: HeightField,
    maps: ConstructorParameters<typeof SheetScene>[2],
    private readonly options: ViewerOptions,
  ) {
    const { interactive = true, onChange: _c, onPoint: _p, signal: _s, ...initial } = options;
    const defined = Object.fromEntries(Object.entries(initial).filter(([, value]) => value !== undefined));
    this.state = normalizeView({ ...DEFAULT_VIEW, ...defined });
    this.canvas.className = "viewer-canvas";
    this.host.append(this.canvas);
    this.scene = new SheetScene(this.canvas, field, maps, facts.source === "photometric" ? 0 : SHEEN);
    if (interactive) this.listenForInput();
    const observer = new ResizeObserver(() => this.resize());
    observer.observe(host);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const repaint = () => this.invalidate();
    dark.addEventListener("change", repaint);
    this.canvas.addEventListener("webglcontextrestored", () => (this.scene.restore(), repaint()));
    this.cleanups.push(
      () => observer.disconnect(),
      () => dark.removeEventListener("change", repaint),
    );
    this.resize();
    if (facts.tiles) this.showTiles(facts.tiles);
  }

  get interval(): number {
    return this.scene.interval;
  }

  set(partial: Partial<ViewState>): void {
    cancelAnimationFrame(this.animation);
    this.change(partial);
  }

  animateTo(partial: Partial<ViewState>, milliseconds = 1100): void {
    cancelAnimationFrame(this.animation);
    const target = normalizeView({ ...this.state, ...partial });
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return this.change(target);
    const from = this.state;
    const [start, end] = [this.currentCamera(), target.camera ?? this.scene.defaultCamera(target.mode)];
    const turn = ((target.tilt - from.tilt + 540) % 360) - 180;
    this.change({ ...target, tilt: from.tilt, slant: from.slant, exaggeration: from.exaggeration, camera: start });
    let first: number | null = null;
    const step = (now: number) => {
      first ??= now;
      const t = Math.min(1, (now - first) / milliseconds);
      const s = t * t * (3 - 2 * t);
      if (t === 1) return this.change({ ...target });
      this.change({
        tilt: from.tilt + turn * s,
        slant: from.slant + (target.slant - from.slant) * s,
        exaggeration: from.exaggeration + (target.exaggeration - from.exaggeration) * s,
        camera: interpolateCamera(start, end, s),
      });
      this.animation = requestAnimationFrame(step);
    };
    this.animation = requestAnimationFrame(step);
  }

  link(other: Viewer | null): void {
    if (this.other === other) return;
    const before = this.other;
    this.other = other;
    before?.link(null);
    if (!other) return;
    other.link(this);
    this.share(Object.fromEntries(SHARED.map((name) => [name, this.state[name]])));
  }

  async snapshot(): Promise<Blob> {
    this.draw();
    const { width, height } = this.canvas;
    const sheet = new OffscreenCanvas(width, height);
    const context = sheet.getContext("2d");
    if (!context) throw new Error("no 2-D canvas");
    context.fillStyle = getComputedStyle(this.host).getPropertyValue("--paper").trim() || "#fff";
    context.fillRect(0, 0, width, height);
    context.drawImage(this.canvas, 0, 0); // in the same task as rendering: the drawing buffer is not preserved
    return sheet.convertToBlob({ type: "image/png" });
  }

  async relit(): Promise<Blob> {
    const { width, height, pixels } = this.scene.renderFlat(this.state);
    const sheet = new OffscreenCanvas(width, height);
    sheet.getContext("2d")?.putImageData(new ImageData(pixels, width, height), 0, 0);
    this.invalidate();
    return sheet.convertToBlob({ type: "image/png" });
  }

  resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const size = [width, height, ratio].join();
    if (!width || !height || size === this.size) return; // an observer also reports the size that it finds at first
    this.size = size;
    this.scene.resize(width, height, ratio);
    this.draw();
  }

  dispose(): void {
    cancelAnimationFrame(this.frame);
    cancelAnimationFrame(this.animation);
    this.link(null);
    this.cleanups.forEach((end) => end());
    this.listeners.clear();
    this.scene.dispose();
    this.canvas.remove();
  }

  pick(x: number, y: number): SheetPoint | null {
    const { clientWidth: width, clientHeight: height } = this.host;
    const through = new Vector3((x / width) * 2 - 1, 1 - (y / height) * 2, 0.5).unproject(this.scene.camera);
    const eye = this.scene.camera.position;
    const direction = through.sub(eye).normalize();
    const hit = this.field.intersectRay(eye.toArray(), direction.toArray(), this.lift());
    return hit && { x: hit.u, y: hit.v, height: this.field.at(hit.u, hit.v) };
  }

  section(line: SheetLine): ProfilePoint[] {
    return this.field.section(line);
  }

  project(u: number, v: number): { x: number; y: number } | null {
    const point = new Vector3(...this.field.point(u, v, this.lift())).project(this.scene.camera);
    if (point.z > 1) return null;
    return { x: ((point.x + 1) / 2) * this.host.clientWidth, y: ((1 - point.y) / 2) * this.host.clientHeight };
  }

  onDraw(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  async immerse(kind: SessionMode): Promise<void> {
    await enterSession(this.scene, () => this.state, kind);
    this.size = ""; // the headset's was drawn
    this.resize();
  }

  private lift(): number {
    return this.state.mode === "sheet" ? 0 : this.state.exaggeration;
  }

  private currentCamera(): Camera {
    return this.state.camera ?? this.scene.defaultCamera(this.state.mode);
  }

  private change(partial: Partial<ViewState>): void {
    this.state = normalizeView({ ...this.state, ...partial });
    this.invalidate();
    this.options.onChange?.(this.state);
    this.share(partial);
  }

  /** Passes what both viewers share to the other one, which does not pass it back. */
  private share(partial: Partial<ViewState>): void {
    const shared = Object.fromEntries(SHARED.filter((name) => name in partial).map((name) => [name, partial[name]]));
    if (!this.other || syncing || !Object.keys(shared).length) return;
    syncing = true;
    this.other.set(shared);
    syncing = false;
  }

  private invalidate(): void {
    this.frame ||= requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.scene.draw(this.state, this.lensPosition());
    const detail = this.scene.detailState;
    if (detail) Object.assign(this.canvas.dataset, { factor: detail.factor, missing: detail.missing, tileBytes: detail.bytes, heights: detail.heights });
    this.listeners.forEach((listener) => listener());
  }

  /** Works larger than their maps become sharp; where their tiles cannot be had, they stay as they are. */
  private showTiles(services: TileServices): void {
    const controller = new AbortController();
    this.cleanups.push(() => controller.abort());
    this.scene.showTiles(services, () => this.invalidate(), controller.signal);
  }

  private lensPosition(): LensPosition | null {
    if (this.state.lens === "none") return null;
    const middle = { x: this.host.clientWidth / 2, y: this.host.clientHeight / 2 };
    const point = this.lens ?? middle;
    const [centre, edge] = [this.pick(point.x, point.y), this.pick(point.x + 1, point.y)];
    if (!centre) return null;
    // The size of a screen pixel on the sheet here, so that the lens has the same size on the screen everywhere.
    const per = edge ? Math.abs(edge.x - centre.x) * this.field.wide : 1 / this.host.clientHeight;
    return { u: centre.x, v: centre.y, radius: Math.max(per, 1e-6) * LENS_RADIUS, pixels: LENS_RADIUS };
  }

  private listenForInput(): void {
    this.host.tabIndex = 0;
    const size = () => ({ width: this.host.clientWidth, height: this.host.clientHeight });
    const off = listenForInput(this.host, {
      action: () => this.action(),
      light: (x, y) => this.set(lightAt(x, y, size())),
      orbit: (dx, dy) => this.set({ camera: orbit(this.currentCamera(), -dx * 0.008, dy * 0.008) }),
      pan: (dx, dy) => this.set({ camera: pan(this.currentCamera(), -dx / size().height, dy / size().height) }),
      zoom: (factor, x, y) => {
        const { width, height } = size();
        this.set({ camera: zoom(this.currentCamera(), factor, (x - width / 2) / height, (height / 2 - y) / height) });
      },
      line: (phase, x, y) => this.line(phase, x, y),
      point: (x, y) => {
        const point = this.pick(x, y);
        if (point) this.options.onPoint?.(point);
      },
      hover: (point) => {
        if (point) this.lens = point;
        if (this.state.lens !== "none") this.invalidate();
      },
      key: (event) => this.key(event),
    });
    this.cleanups.push(off);
  }

  private action(): Action {
    if (this.tool === "section" || this.tool === "ruler") return "line";
    if (this.tool === "pin") return "point";
    if (this.tool === "light") return "light";
    return this.state.mode === "sheet" ? "pan" : "orbit";
  }

  private line(phase: "start" | "move" | "end", x: number, y: number): void {
    const kind = this.tool === "ruler" ? "ruler" : "section";
    const point = this.pick(x, y);
    if (phase === "start") this.drawn = point && { line: kind, from: point };
    else if (this.drawn && point) this.set({ [this.drawn.line]: [this.drawn.from.x, this.drawn.from.y, point.x, point.y] });
    if (phase === "end") this.drawn = null;
  }

  private key(event: KeyboardEvent): boolean {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    const { tilt, slant } = this.state;
    const camera = this.currentCamera();
    const turns: Record<string, () => Partial<ViewState>> = event.shiftKey
      ? {
          ArrowLeft: () => ({ camera: orbit(camera, -0.1, 0) }),
          ArrowRight: () => ({ camera: orbit(camera, 0.1, 0) }),
          ArrowUp: () => ({ camera: orbit(camera, 0, 0.1) }),
          ArrowDown: () => ({ camera: orbit(camera, 0, -0.1) }),
        }
      : {
          ArrowLeft: () => ({ tilt: tilt + KEY_STEP }),
          ArrowRight: () => ({ tilt: tilt - KEY_STEP }),
          ArrowUp: () => ({ slant: slant - KEY_STEP }),
          ArrowDown: () => ({ slant: slant + KEY_STEP }),
        };
    const step = (right: number, up: number) => () => ({ camera: pan(camera, right * PAN_STEP, up * PAN_STEP) });
    const pans: Record<string, () => Partial<ViewState>> = { ArrowLeft: step(-1, 0), ArrowRight: step(1, 0), ArrowUp: step(0, 1), ArrowDown: step(0, -1) };
    const common: Record<string, () => Partial<ViewState>> = {
      "+": () => ({ camera: zoom(camera, 0.85) }),
      "=": () => ({ camera: zoom(camera, 0.85) }),
      "-": () => ({ camera: zoom(camera, 1 / 0.85) }),
      "0": () => ({ camera: null }),
    };
    const moves = this.action() === "pan" && !event.shiftKey ? pans : turns;
    const change = (moves[event.key] ?? common[event.key])?.();
    if (change) this.set(change);
    return change !== undefined;
  }
}
