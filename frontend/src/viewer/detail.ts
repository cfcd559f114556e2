// The part of the flat sheet that is seen, at the sharpness of the screen: tiles of each map that is shown, drawn into a picture of the
// screen's size whenever the view changes or a tile has come. The sheet is then lit from these, so that moving the lamp draws no tiles.
// What the lens shows has pictures of its own, since it may be magnified.

import {
  BufferAttribute,
  BufferGeometry,
  ClampToEdgeWrapping,
  GLSL3,
  LinearFilter,
  Mesh,
  NoColorSpace,
  OrthographicCamera,
  type PerspectiveCamera,
  RawShaderMaterial,
  Scene,
  SRGBColorSpace,
  Texture,
  Vector3,
  Vector4,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import type { TiledMap, TileServices } from "../types";
import { loadPicture } from "./loading";
import { drawingOrder, loadInfo, neededTiles, type Part, type Pyramid, readPyramid, type Tile } from "./pyramid";
import { TileCache } from "./tileCache";

/** Bytes of graphics memory that the tiles of all maps may take. */
const MAX_BYTES = 96e6;
const MAX_BYTES_ON_A_PHONE = 48e6;
/** Of the bytes of one map, what the tiles of one view may take, and of the lens: others stay in memory for the way back. */
const SHARE_OF_VIEW = 0.7;
const SHARE_OF_LENS = 0.2;
/** How far beyond the sheet its part may reach where it is seen aslant; fractions of the sheet. */
const BEYOND = 0.05;

/** What a page may want to know: pixels of the work for one of the tiles shown, how many tiles are still to come, bytes of tiles. */
export type DetailState = { factor: number; missing: number; bytes: number };
/** Whether a picture shows the whole view or what is in the lens. */
export type ViewName = "sheet" | "lens";
/** A part of the sheet, how large it is on the screen, and which maps are shown of it. */
export type Window = { part: Part; size: { x: number; y: number }; maps: readonly TiledMap[] };

/** pyramid: null until it has come (`awaited`), and where there are no tiles. targets: what is drawn of the map for each view. */
type Layer = { tiles: TileCache<Texture>; base: Texture; encoded: boolean; pyramid: Pyramid | null; awaited: boolean; targets: Map<ViewName, WebGLRenderTarget> };
type Needed = { layer: Layer; sharp: Tile[]; factor: number };

const vertex = /* glsl */ `
in vec3 position;
uniform vec4 area; // left, top, width, height as fractions of the picture
out vec2 at;
void main() {
  at = position.xy;
  gl_Position = vec4((area.xy + position.xy * area.zw) * 2.0 - 1.0, 0.0, 1.0);
}`;
const fragment = /* glsl */ `
precision highp float;
uniform sampler2D picture;
in vec2 at;
out vec4 colour;
void main() { colour = vec4(texture(picture, at).rgb, 1.0); }`;

export class SheetDetail {
  /** What of the sheet the pictures of a view show: left, top, width, height as fractions. */
  readonly parts: Record<ViewName, Vector4> = { sheet: new Vector4(0, 0, 1, 1), lens: new Vector4(0, 0, 1, 1) };
  state: DetailState = { factor: 0, missing: 0, bytes: 0 };
  private readonly scene = new Scene();
  private readonly camera = new OrthographicCamera();
  private readonly quad: Mesh<BufferGeometry, RawShaderMaterial>;
  private readonly layers = new Map<TiledMap, Layer>();
  private readonly drawn: Partial<Record<ViewName, string>> = {};
  private readonly maxBytes = matchMedia("(pointer: coarse)").matches ? MAX_BYTES_ON_A_PHONE : MAX_BYTES;

  /** base: the maps of the whole sheet, which are shown until tiles come. onChange: called when one has come. */
  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly base: Partial<Record<TiledMap, Texture>>,
    private readonly services: TileServices,
    private readonly onChange: () => void,
    private readonly signal: AbortSignal,
  ) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0]), 3));
    const uniforms = { area: { value: new Vector4() }, picture: { value: null } };
    const material = new RawShaderMaterial({ glslVersion: GLSL3, vertexShader: vertex, fragmentShader: fragment, uniforms, depthTest: false, depthWrite: false });
    this.quad = new Mesh(geometry, material);
    this.quad.frustumCulled = false;
    this.scene.add(this.quad);
  }

  /** A map as a view shows it; null of one that it does not show. */
  texture(view: ViewName, name: TiledMap): Texture | null {
    return this.layers.get(name)?.targets.get(view)?.texture ?? null;
  }

  /** Draws what the windows show of the sheet, as sharp as the tiles in memory are, and loads those that are missing. */
  update(windows: { sheet: Window; lens: Window | null }): void {
    const shown = Object.entries(windows).filter((entry): entry is [ViewName, Window] => entry[1] !== null);
    const active = [...new Set(shown.flatMap(([, { maps }]) => maps))].map((name) => this.layer(name));
    const needed = new Map<ViewName, Needed[]>();
    const wanted = new Map<Layer, Tile[]>();
    for (const [view, window] of shown) {
      const across = window.size.x / (window.part.right - window.part.left);
      const share = (this.maxBytes / active.length) * (view === "lens" ? SHARE_OF_LENS : SHARE_OF_VIEW);
      const found = window.maps.map((name) => {
        const layer = this.layer(name);
        const tiles = layer.pyramid ? neededTiles(layer.pyramid, window.part, across, share) : { sharp: [], coarse: [] };
        wanted.set(layer, [...(wanted.get(layer) ?? []), ...tiles.coarse, ...tiles.sharp]);
        return { layer, sharp: tiles.sharp, factor: tiles.sharp[0]?.factor ?? 1 };
      });
      needed.set(view, found);
    }
    for (const layer of this.layers.values()) {
      layer.tiles.maxBytes = this.maxBytes / active.length;
      if (active.includes(layer)) layer.tiles.want(wanted.get(layer) ?? []);
      else this.release(layer);
    }
    const all = [...needed.values()].flat();
    this.state = {
      factor: needed.get("sheet")![0]?.factor ?? 1,
      missing: all.reduce((sum, { layer, sharp }) => sum + layer.tiles.missing(sharp) + Number(layer.awaited), 0),
      bytes: active.reduce((sum, { tiles }) => sum + tiles.bytes, 0),
    };
    for (const [view, window] of shown) this.draw(view, window, needed.get(view)!);
  }

  /** Begins anew when the graphics card has lost its pictures. */
  reload(): void {
    this.drawn.sheet = this.drawn.lens = "";
    this.layers.forEach(({ tiles }) => tiles.clear());
  }

  dispose(): void {
    this.layers.forEach((layer) => this.release(layer));
    this.quad.geometry.dispose();
    this.quad.material.dispose();
  }

  /** A map, whose tiles are asked for when it is first shown; where there are none, its base is shown alone. */
  private layer(name: TiledMap): Layer {
    const known = this.layers.get(name);
    if (known) return known;
    const encoded = name !== "normals";
    const load = async (url: string, cancelled: AbortSignal) => tileTexture(this.renderer, await loadPicture(url, cancelled), encoded);
    const { onChange } = this;
    const tiles = new TileCache<Texture>(this.maxBytes, { load, free: (texture) => texture.dispose(), onChange });
    const { [name]: service, version } = this.services;
    const layer: Layer = { tiles, base: this.base[name] ?? this.base.albedo!, encoded, pyramid: null, awaited: Boolean(service), targets: new Map() };
    this.layers.set(name, layer);
    const come = (pyramid: Pyramid | null) => {
      Object.assign(layer, { pyramid, awaited: false });
      onChange();
    };
    if (service) void loadInfo(service, version, this.signal)
        .then((info) => readPyramid(service, version, info))
        .then(come, () => this.signal.aborted || come(null));
    return layer;
  }

  /** Gives up what is kept of a map that is not shown. */
  private release({ tiles, targets }: Layer): void {
    if (!targets.size && !tiles.bytes) return;
    tiles.clear();
    targets.forEach((target) => target.dispose());
    targets.clear();
  }

  private draw(view: ViewName, { part, size, maps }: Window, needed: Needed[]): void {
    const shows = JSON.stringify([part, size, maps, needed.map(({ layer }) => layer.tiles.changes)]);
    if (shows === this.drawn[view]) return;
    this.drawn[view] = shows;
    this.parts[view].set(part.left, part.top, part.right - part.left, part.bottom - part.top);
    for (const { layer, factor } of needed) this.compose(layer, view, part, factor, size);
  }

  private compose(layer: Layer, view: ViewName, part: Part, factor: number, size: { x: number; y: number }): void {
    const { tiles, base, encoded, targets } = layer;
    const target = targets.get(view) ?? new WebGLRenderTarget(1, 1, { depthBuffer: false, colorSpace: encoded ? SRGBColorSpace : NoColorSpace });
    targets.set(view, target);
    target.setSize(size.x, size.y);
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    const auto = this.renderer.autoClear;
    this.renderer.autoClear = false;
    this.drawQuad(base, { left: 0, top: 0, right: 1, bottom: 1 }, part);
    const seen = [...tiles.all].filter(({ tile: { area } }) => overlaps(area, part)).map(({ tile }) => tile);
    for (const tile of drawingOrder(seen, factor)) {
      const texture = tiles.use(tile);
      if (texture) this.drawQuad(texture, tile.area, part);
    }
    this.renderer.autoClear = auto;
    this.renderer.setRenderTarget(null);
  }

  private drawQuad(texture: Texture, area: Part, part: Part): void {
    const [wide, tall] = [part.right - part.left, part.bottom - part.top];
    const { uniforms } = this.quad.material;
    uniforms.area!.value.set((area.left - part.left) / wide, (area.top - part.top) / tall, (area.right - area.left) / wide, (area.bottom - area.top) / tall);
    uniforms.picture!.value = texture;
    this.quad.material.uniformsNeedUpdate = true;
    this.renderer.render(this.scene, this.camera);
  }
}

const overlaps = (a: Part, b: Part): boolean => a.left < b.right && a.right > b.left && a.top < b.bottom && a.bottom > b.top;

/** Uploaded at once, so that the decoded picture need not stay in memory. */
function tileTexture(renderer: WebGLRenderer, bitmap: ImageBitmap, encoded: boolean): Texture {
  const texture = new Texture(bitmap);
  texture.flipY = false;
  texture.generateMipmaps = false;
  texture.colorSpace = encoded ? SRGBColorSpace : NoColorSpace;
  texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  renderer.initTexture(texture);
  bitmap.close();
  return texture;
}

/** What of the flat sheet a camera sees: all of its picture where it looks straight on, else the box around it. */
export function visiblePart(camera: PerspectiveCamera, sheet: { wide: number; tall: number }): Part {
  const eye = camera.position;
  const corners = [-1, 1].flatMap((x) => [-1, 1].map((y) => new Vector3(x, y, 0.5).unproject(camera).sub(eye)));
  const points = corners.map(({ x, y, z }) => {
    const t = z < 0 ? -eye.z / z : Infinity;
    const along = (from: number, by: number) => (Number.isFinite(t) ? from + by * t : Math.sign(by) * Number.MAX_SAFE_INTEGER);
    return { u: along(eye.x, x) / sheet.wide + 0.5, v: 0.5 - along(eye.y, y) / sheet.tall };
  });
  const [us, vs] = [points.map((point) => point.u), points.map((point) => point.v)];
  const part = { left: Math.min(...us), top: Math.min(...vs), right: Math.max(...us), bottom: Math.max(...vs) };
  const straight = Math.hypot(corners[0]!.x + corners[3]!.x, corners[0]!.y + corners[3]!.y) < 1e-6;
  if (straight) return part;
  const within = (value: number) => Math.min(1 + BEYOND, Math.max(-BEYOND, value));
  return { left: within(part.left), top: within(part.top), right: within(part.right), bottom: within(part.bottom) };
}
