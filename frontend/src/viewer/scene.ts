// The three.js scene of one sheet: textures, mesh, one material for every mode. It renders only when asked to.

import {
  type BufferGeometry,
  ClampToEdgeWrapping,
  Color,
  DataTexture,
  DoubleSide,
  FloatType,
  GLSL3,
  LinearFilter,
  LinearMipmapLinearFilter,
  Mesh,
  NearestFilter,
  NoColorSpace,
  OrthographicCamera,
  PerspectiveCamera,
  RawShaderMaterial,
  RedFormat,
  Scene,
  SRGBColorSpace,
  Texture,
  Vector2,
  Vector3,
  Vector4,
  WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { lampDirection, mixtureWeights, type Vec3 } from "./shading";
import { niceStep } from "./scales";
import { fragment, vertex } from "./shaders";
import { type HeightField, heightIn, smoothed } from "./heightfield";
import { grid, squares, WHOLE } from "./grid";
import { type HeightPatch, NearHeights } from "./nearHeights";
import { FIELD_OF_VIEW, fitCamera } from "./camera";
import type { TiledMap, TileServices } from "../types";
import { type DetailState, SheetDetail, type ViewName, visiblePart, type Window } from "./detail";
import type { Part } from "./pyramid";
import { type Camera, type Lens, LOOKS, type Mode, type ViewState } from "./state";

/** Decoded pictures of one sheet. `photo`: null where the albedo is the picture itself. `lamps`: three photographs, if there are; `mask`: white where the surface was measured, if only in part. */
export type Maps = {
  albedo: ImageBitmap;
  normals: ImageBitmap;
  photo: ImageBitmap | null;
  mask: ImageBitmap | null;
  lamps: null | { a: ImageBitmap; b: ImageBitmap; c: ImageBitmap; slant: number };
};

const SHADER_MODES: Record<Mode | Exclude<Lens, "none" | "heights">, number> = {
  sheet: 0,
  surface: 0,
  mesh: 1,
  heights: 2,
  contours: 3,
  picture: 4,
  normals: 5,
  magnify: 6,
};
/** Squares along the longer side: few for the flat sheet, many for a surface, and so many that each can be seen in the mesh mode. */
const FLAT_SQUARES = 2;
const SURFACE_SQUARES = 256;
const MESH_SQUARES = 96;
const CONTOUR_COUNT = 14;
/** Texels over which heights are averaged for contour lines, which follow each grain else. */
const CONTOUR_REACH = 3;
/** The viewing position for the flat sheet: so far away that it is straight above every point. */
const DISTANT_EYE: Vec3 = [0, 0, 1e4];

/** u, v: its middle, fractions of the sheet; radius: as a fraction of the longer side; pixels: its radius on the screen, in CSS pixels. */
export type LensPosition = { u: number; v: number; radius: number; pixels: number };

/** How many times longer than the screen's the picture of a part that is seen aslant may be. */
const ASLANT = 1.5;
/** How many times larger the lens that magnifies shows things. */
const MAGNIFIED = 2.5;
/** The uniform of each map that is drawn from tiles. */
const TILED: Record<TiledMap, string> = { albedo: "albedo", normals: "normals", picture: "photo", "lamp-a": "lampA", "lamp-b": "lampB", "lamp-c": "lampC" };
const LIT: TiledMap[] = ["albedo", "normals"];
const MIXED: TiledMap[] = ["lamp-a", "lamp-b", "lamp-c"];

type Relief = { patch: HeightPatch | null; grids: Map<number, BufferGeometry>; heights: Map<number, DataTexture> };

export class SheetScene {
  readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 30);
  readonly sheet: Mesh<BufferGeometry, RawShaderMaterial>;
  /** Units of height between two contour lines. */
  readonly interval: number;
  private readonly textures: Texture[] = [];
  /** The maps of the whole sheet. */
  private readonly base: Record<TiledMap, Texture>;
  private detail: SheetDetail | null = null;
  private near: NearHeights | null = null;
  /** Meshes by their number of squares, and heights averaged over so many texels: of the whole sheet, and of the part that is seen from nearby. */
  private readonly whole: Relief = { patch: null, grids: new Map(), heights: new Map() };
  private part: Relief = this.whole;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly field: HeightField,
    private readonly maps: Maps,
    /** How much the ink shines under the warm lamp; 0 where the surface was measured. */
    private readonly sheen: number,
  ) {
    this.renderer = new WebGLRenderer({ canvas, alpha: true, antialias: true });
    this.renderer.setClearColor(0, 0);
    this.interval = niceStep(field.max - field.min, CONTOUR_COUNT);
    const { lamps, photo } = maps;
    const albedo = this.texture(maps.albedo, true);
    const light = (bitmap: ImageBitmap | undefined | null) => (bitmap ? this.texture(bitmap, true) : albedo);
    this.base = { albedo, normals: this.texture(maps.normals, false), picture: light(photo), "lamp-a": light(lamps?.a), "lamp-b": light(lamps?.b), "lamp-c": light(lamps?.c) };
    this.sheet = new Mesh(this.grid(FLAT_SQUARES, this.whole), this.material());
    this.sheet.frustumCulled = false; // heights are only known on the GPU
    this.scene.add(this.sheet);
  }

  resize(width: number, height: number, ratio: number): void {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
  }

  /** The camera of a state whose camera is null. */
  defaultCamera(mode: Mode): Camera {
    return fitCamera(mode, this.field, this.camera.aspect);
  }

  draw(state: ViewState, lensPosition: LensPosition | null): void {
    const [x, y, z, tx, ty, tz] = state.camera ?? this.defaultCamera(state.mode);
    this.camera.position.set(x, y, z);
    this.camera.lookAt(tx, ty, tz);
    this.camera.updateMatrixWorld();
    const part = visiblePart(this.camera, this.field);
    const relief = this.reliefOf(state.mode === "sheet" ? null : (this.near?.over(part) ?? null));
    this.prepare(state, lensPosition, state.mode === "sheet" ? DISTANT_EYE : [x, y, z], relief);
    const window = this.detail && this.sharpWindow(state.mode, part);
    if (this.detail && window) this.drawSharp(this.detail, window, state.lens, lensPosition);
    else this.renderer.render(this.scene, this.camera);
  }

  /** From now on the flat sheet is as sharp as the screen. onChange: called when it can be drawn sharper. */
  showTiles(services: TileServices, onChange: () => void, signal: AbortSignal): void {
    this.detail = new SheetDetail(this.renderer, this.base, services, onChange, signal);
    if (services.heights) this.near = new NearHeights(services, this.field, this.field.width, onChange, signal);
    onChange();
  }

  /** Begins anew after the graphics card has lost its pictures. */
  restore(): void {
    this.detail?.reload();
  }

  /** What is shown of the detail; null without any. heights: those that are drawn along the width of the whole. */
  get detailState(): (DetailState & { heights: number }) | null {
    if (!this.detail) return null;
    const { patch } = this.part;
    const heights = patch ? Math.round(patch.width / (patch.part.right - patch.part.left)) : this.field.width;
    return { ...this.detail.state, missing: this.detail.state.missing + (this.near?.missing ?? 0), heights };
  }

  /** What of the sheet is drawn from tiles, and how large; null where the maps of the whole are as fine. */
  private sharpWindow(mode: Mode, part: Part): Omit<Window, "maps"> | null {
    const size = this.renderer.getDrawingBufferSize(new Vector2());
    if (mode === "sheet") return { part, size };
    if (mode === "mesh") return null;
    const seen = { left: Math.max(part.left, 0), top: Math.max(part.top, 0), right: Math.min(part.right, 1), bottom: Math.min(part.bottom, 1) };
    const [wide, tall] = [(seen.right - seen.left) * this.field.wide, (seen.bottom - seen.top) * this.field.tall];
    const pixels = size.y / (2 * this.camera.position.z * Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180))); // for a length of 1, straight below
    if (!(wide > 0 && tall > 0) || pixels * this.field.wide <= this.maps.albedo.width) return null;
    const fit = Math.min(1, Math.sqrt((size.x * size.y) / (wide * tall * pixels ** 2)) * ASLANT);
    return { part: seen, size: { x: Math.max(1, Math.round(wide * pixels * fit)), y: Math.max(1, Math.round(tall * pixels * fit)) } };
  }

  /** Draws the sheet, and then what is in the lens over it, each from its own part of the tiles. */
  private drawSharp(detail: SheetDetail, window: Omit<Window, "maps">, lens: Lens, position: LensPosition | null): void {
    const { uniforms } = this.sheet.material;
    const maps = uniforms.mixture!.value.lengthSq() > 0 ? MIXED : LIT;
    const sheet = { ...window, maps };
    const through = lens === "none" || !position ? null : this.lensWindow(lens, position, maps);
    detail.update({ sheet, lens: through });
    const number = uniforms.lens!.value;
    uniforms.lens!.value = -1;
    this.render(detail, "sheet");
    if (!through) return;
    uniforms.lens!.value = number;
    uniforms.lensAlone!.value = this.sheet.material.transparent = true;
    this.renderer.autoClear = false;
    this.render(detail, "lens");
    this.renderer.autoClear = true;
    uniforms.lensAlone!.value = this.sheet.material.transparent = false;
  }

  private render(detail: SheetDetail, view: ViewName): void {
    const { uniforms } = this.sheet.material;
    for (const [map, name] of Object.entries(TILED) as [TiledMap, string][]) uniforms[name]!.value = detail.texture(view, map) ?? this.base[map];
    uniforms.part!.value.copy(detail.parts[view]);
    this.renderer.render(this.scene, this.camera);
  }

  /** What of the sheet a lens shows, and by which maps. */
  private lensWindow(lens: Lens, { u, v, radius, pixels }: LensPosition, shown: TiledMap[]): Window {
    const reach = lens === "magnify" ? radius / MAGNIFIED : radius;
    const [x, y] = [reach / this.field.wide, reach / this.field.tall];
    const side = Math.ceil(2 * pixels * this.renderer.getPixelRatio());
    const photograph: TiledMap = this.maps.photo ? "picture" : "albedo";
    const maps: Record<Lens, TiledMap[]> = { none: [], magnify: shown, picture: [photograph], heights: ["normals"], normals: ["normals"] };
    return { part: { left: u - x, top: v - y, right: u + x, bottom: v + y }, size: { x: side, y: side }, maps: maps[lens] };
  }

  /** The flat sheet under the state's lamp, one pixel for each texel of the albedo: RGBA rows from the top. */
  renderFlat(state: ViewState): { width: number; height: number; pixels: Uint8ClampedArray<ArrayBuffer> } {
    const { width, height } = this.maps.albedo;
    const target = new WebGLRenderTarget(width, height, { depthBuffer: false });
    const { wide, tall } = this.field;
    const camera = new OrthographicCamera(-wide / 2, wide / 2, tall / 2, -tall / 2, 0.1, 10);
    camera.position.z = 2;
    this.prepare({ ...state, mode: "sheet", lens: "none" }, null, DISTANT_EYE, this.whole);
    this.renderer.setRenderTarget(target);
    this.renderer.render(this.scene, camera);
    const rows = new Uint8Array(width * height * 4);
    this.renderer.readRenderTargetPixels(target, 0, 0, width, height, rows);
    this.renderer.setRenderTarget(null);
    target.dispose();
    return { width, height, pixels: flipRows(rows, width, height) };
  }

  dispose(): void {
    this.detail?.dispose();
    this.textures.forEach((texture) => texture.dispose());
    this.reliefOf(null);
    freeRelief(this.whole);
    this.sheet.material.dispose();
    const { albedo, normals, photo, mask, lamps } = this.maps;
    [albedo, normals, photo, mask, lamps?.a, lamps?.b, lamps?.c].forEach((bitmap) => bitmap?.close());
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  /** The meshes and heights of a patch, those of the one before it being given up; of the whole where there is none. */
  private reliefOf(patch: HeightPatch | null): Relief {
    if (this.part.patch === patch) return this.part;
    if (this.part !== this.whole) freeRelief(this.part);
    this.field.near = patch;
    return (this.part = patch ? { patch, grids: new Map(), heights: new Map() } : this.whole);
  }

  private prepare(state: ViewState, lensPosition: LensPosition | null, eye: Vec3, relief: Relief): void {
    const meshSquares = relief.patch ? 2 * MESH_SQUARES : MESH_SQUARES; // of a part about half is on the screen
    const longest = state.mode === "sheet" ? FLAT_SQUARES : state.mode === "mesh" ? meshSquares : SURFACE_SQUARES;
    this.sheet.geometry = this.grid(longest, relief);
    const uniform = (name: string) => this.sheet.material.uniforms[name]!;
    uniform("mode").value = SHADER_MODES[state.mode];
    uniform("lens").value = state.lens === "none" || !lensPosition ? -1 : SHADER_MODES[state.lens];
    uniform("lensPosition").value.set(lensPosition?.u ?? 0, lensPosition?.v ?? 0, lensPosition?.radius ?? 0);
    uniform("light").value.set(...lampDirection(state.tilt, state.slant));
    uniform("lift").value = state.mode === "sheet" ? 0 : state.exaggeration / this.field.scale;
    uniform("exaggeration").value = this.litExaggeration(state);
    uniform("heights").value = this.heights(0, relief);
    uniform("smoothed").value = this.heights(state.mode === "contours" ? CONTOUR_REACH : this.squareSize(longest, relief), relief);
    const known = relief.patch?.part ?? WHOLE;
    uniform("known").value.set(known.left, known.top, known.right - known.left, known.bottom - known.top);
    uniform("look").value = LOOKS.indexOf(state.look);
    uniform("eye").value.set(...eye);
    uniform("cells").value.set(...squares(this.field, longest, known));
    for (const [map, name] of Object.entries(TILED) as [TiledMap, string][]) uniform(name).value = this.base[map];
    uniform("part").value.set(0, 0, 1, 1);
    const { lamps, mask } = this.maps;
    uniform("cut").value = mask !== null && state.mode !== "sheet";
    uniform("mixture").value.set(...(state.mixture && lamps ? mixtureWeights(state.tilt, state.slant, lamps.slant) : [0, 0, 0]));
    const style = getComputedStyle(this.canvas);
    const paint = (name: string, token: string) => {
      const colour = new Color().setStyle(style.getPropertyValue(token).trim() || "#888", NoColorSpace);
      uniform(name).value.set(colour.r, colour.g, colour.b);
    };
    paint("inkColour", "--ink");
    paint("paperColour", "--sheet");
  }

  private material(): RawShaderMaterial {
    const { field, maps } = this;
    const { albedo } = this.base;
    const heights = this.heights(0, this.whole);
    return new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: vertex,
      fragmentShader: fragment,
      side: DoubleSide,
      uniforms: {
        heights: { value: heights },
        smoothed: { value: heights },
        known: { value: new Vector4(0, 0, 1, 1) },
        ...Object.fromEntries(Object.entries(TILED).map(([map, name]) => [name, { value: this.base[map as TiledMap] }])),
        photographed: { value: maps.photo !== null },
        part: { value: new Vector4(0, 0, 1, 1) },
        mask: { value: maps.mask ? this.texture(maps.mask, false) : albedo },
        cut: { value: false },
        mode: { value: 0 },
        lens: { value: -1 },
        lensAlone: { value: false },
        lensPosition: { value: new Vector3() },
        sheet: { value: new Vector2(field.wide, field.tall) },
        light: { value: new Vector3(0, 0, 1) },
        mixture: { value: new Vector3() },
        exaggeration: { value: 1 },
        lift: { value: 0 },
        cells: { value: new Vector2(1, 1) },
        range: { value: new Vector2(field.min, field.max) },
        interval: { value: this.interval },
        look: { value: 0 },
        sheen: { value: this.sheen },
        eye: { value: new Vector3() },
        inkColour: { value: new Vector3() },
        paperColour: { value: new Vector3(1, 1, 1) },
      },
    });
  }

  /** By how much slopes are exaggerated where they are lit. The ink of a drawn relief under the warm lamp keeps more of its gloss. */
  private litExaggeration({ exaggeration, look }: ViewState): number {
    const drawn = this.sheen > 0 && LOOKS[0] === look;
    return drawn && exaggeration > 1 ? Math.sqrt(exaggeration) : exaggeration;
  }

  /** Texels of the heights to a square of the mesh. */
  private squareSize(longest: number, { patch }: Relief): number {
    const { width, height } = patch ?? this.field;
    return longest === FLAT_SQUARES ? 0 : Math.max(width, height) / longest;
  }

  /** The heights averaged over so many texels, made when first needed. */
  private heights(reach: number, { patch, heights }: Relief): DataTexture {
    const { field, maps } = this;
    const known = heights.get(reach);
    if (known) return known;
    const { width, height } = patch ?? field;
    const weights = maps.mask && reach > 0 && !patch ? sharesMeasured(maps.mask, field) : undefined;
    const values = smoothed(patch ?? field, reach, weights) as Float32Array<ArrayBuffer>;
    const texture = new DataTexture(values, width, height, RedFormat, FloatType);
    texture.minFilter = texture.magFilter = NearestFilter;
    texture.needsUpdate = true;
    heights.set(reach, texture);
    return texture;
  }

  /** The mesh with so many squares, built when first needed. */
  private grid(longest: number, relief: Relief): BufferGeometry {
    const part = relief.patch?.part;
    const geometry = relief.grids.get(longest) ?? grid(this.field, longest, this.vertexHeights(longest, relief), part);
    relief.grids.set(longest, geometry);
    return geometry;
  }

  /** The height at a vertex of the mesh with so many squares, as the shader lifts it; none of the flat sheet. */
  private vertexHeights(longest: number, relief: Relief): ((u: number, v: number) => number) | undefined {
    if (longest === FLAT_SQUARES) return undefined;
    const { width, height, data } = this.heights(this.squareSize(longest, relief), relief).image;
    return (u, v) => heightIn({ values: data as unknown as Float32Array, width, height, part: relief.patch?.part }, u, v);
  }

  private texture(bitmap: ImageBitmap, encoded: boolean): Texture {
    const texture = new Texture(bitmap);
    texture.flipY = false; // first row on top, as everywhere here
    texture.colorSpace = encoded ? SRGBColorSpace : NoColorSpace;
    texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
    texture.magFilter = LinearFilter;
    texture.minFilter = LinearMipmapLinearFilter;
    texture.anisotropy = Math.min(8, this.renderer.capabilities.getMaxAnisotropy());
    texture.needsUpdate = true;
    this.textures.push(texture);
    return texture;
  }
}

function freeRelief({ grids, heights }: Relief): void {
  grids.forEach((geometry) => geometry.dispose());
  heights.forEach((texture) => texture.dispose());
}

/** How much of each texel of the heights was measured, by a mask. */
function sharesMeasured(mask: ImageBitmap, { width, height }: HeightField): Float32Array {
  const context = new OffscreenCanvas(width, height).getContext("2d")!;
  context.drawImage(mask, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  return Float32Array.from({ length: width * height }, (_, k) => data[4 * k]! / 255);
}

function flipRows(rows: Uint8Array, width: number, height: number): Uint8ClampedArray<ArrayBuffer> {
  const pixels = new Uint8ClampedArray(rows.length);
  for (let r = 0; r < height; r++) pixels.set(rows.subarray(r * width * 4, (r + 1) * width * 4), (height - 1 - r) * width * 4);
  return pixels;
}
