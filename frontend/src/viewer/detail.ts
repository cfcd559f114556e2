// The part of the flat sheet that is seen, at the sharpness of the screen: tiles of albedo and normals, drawn into two pictures of the
// screen's size whenever the view changes or a tile has come. The sheet is then lit from these, so that moving the lamp draws no tiles.

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
  Vector2,
  Vector3,
  Vector4,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import type { TileServices } from "../types";
import { loadPicture } from "./loading";
import { drawingOrder, type ImageInfo, neededTiles, type Part, type Pyramid, readPyramid, versionQuery } from "./pyramid";
import { TileCache } from "./tileCache";

const MAPS = ["albedo", "normals"] as const;
type MapName = (typeof MAPS)[number];

/** Bytes of graphics memory that tiles of both maps may take. */
const MAX_BYTES = 96e6;
const MAX_BYTES_ON_A_PHONE = 48e6;
/** Of the bytes of one map, what the tiles of one view may take: others stay in memory for the way back. */
const SHARE_OF_VIEW = 0.8;
/** How far beyond the sheet its part may reach where it is seen aslant; fractions of the sheet. */
const BEYOND = 0.05;

/** What a page may want to know: pixels of the work for one of the tiles shown, how many tiles are still to come, bytes of tiles. */
export type DetailState = { factor: number; missing: number; bytes: number };

type Layer = { pyramid: Pyramid; tiles: TileCache<Texture>; target: WebGLRenderTarget; base: Texture };

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
  /** What of the sheet the two pictures show: left, top, width, height as fractions. */
  readonly part = new Vector4(0, 0, 1, 1);
  state: DetailState = { factor: 0, missing: 0, bytes: 0 };
  private readonly scene = new Scene();
  private readonly camera = new OrthographicCamera();
  private readonly quad: Mesh<BufferGeometry, RawShaderMaterial>;
  private drawn = "";

  private constructor(
    private readonly renderer: WebGLRenderer,
    private readonly sheet: { wide: number; tall: number },
    private readonly layers: Partial<Record<MapName, Layer>>,
  ) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0]), 3));
    const uniforms = { area: { value: new Vector4() }, picture: { value: null } };
    const material = new RawShaderMaterial({ glslVersion: GLSL3, vertexShader: vertex, fragmentShader: fragment, uniforms, depthTest: false, depthWrite: false });
    this.quad = new Mesh(geometry, material);
    this.quad.frustumCulled = false;
    this.scene.add(this.quad);
  }

  /** base: the maps of the whole sheet, which are shown until tiles come. onChange: called when one has come. */
  static async load(
    renderer: WebGLRenderer,
    sheet: { wide: number; tall: number },
    base: Record<MapName, Texture>,
    services: TileServices,
    onChange: () => void,
    signal: AbortSignal,
  ): Promise<SheetDetail> {
    const maxBytes = (matchMedia("(pointer: coarse)").matches ? MAX_BYTES_ON_A_PHONE : MAX_BYTES) / MAPS.length;
    const { version } = services;
    const layer = async (name: MapName): Promise<Layer | null> => {
      const service = services[name];
      if (service === null) return null;
      const encoded = name === "albedo";
      const response = await fetch(`${service}/info.json${versionQuery(version)}`, { signal, credentials: "same-origin" });
      if (!response.ok) throw new Error(`${service}: ${response.status}`);
      const pyramid = readPyramid(service, version, (await response.json()) as ImageInfo);
      const load = async (url: string, cancelled: AbortSignal) => tileTexture(renderer, await loadPicture(url, cancelled), encoded);
      const tiles = new TileCache<Texture>(maxBytes, { load, free: (texture) => texture.dispose(), onChange });
      const target = new WebGLRenderTarget(1, 1, { depthBuffer: false, colorSpace: encoded ? SRGBColorSpace : NoColorSpace });
      return { pyramid, tiles, target, base: base[name] };
    };
    const [albedo, normals] = await Promise.all([layer("albedo"), layer("normals")]);
    return new SheetDetail(renderer, sheet, { ...(albedo && { albedo }), ...(normals && { normals }) });
  }

  /** What is seen of a map; null of one without tiles. */
  texture(name: MapName): Texture | null {
    return this.layers[name]?.target.texture ?? null;
  }

  /** Draws what the camera sees of the sheet, as sharp as the tiles in memory are, and loads those that are missing. */
  update(camera: PerspectiveCamera): void {
    const size = this.renderer.getDrawingBufferSize(new Vector2());
    const part = visiblePart(camera, this.sheet);
    const across = size.x / (part.right - part.left);
    const layers = Object.values(this.layers);
    const needed = layers.map((layer) => {
      const found = neededTiles(layer.pyramid, part, across, layer.tiles.maxBytes * SHARE_OF_VIEW);
      layer.tiles.want([...found.coarse, ...found.sharp]);
      return { layer, sharp: found.sharp, factor: found.sharp[0]?.factor ?? 1 };
    });
    this.state = {
      factor: needed[0]?.factor ?? 1,
      missing: needed.reduce((sum, { layer, sharp }) => sum + layer.tiles.missing(sharp), 0),
      bytes: layers.reduce((sum, { tiles }) => sum + tiles.bytes, 0),
    };
    const shows = JSON.stringify([part, size, layers.map(({ tiles }) => tiles.changes)]);
    if (shows === this.drawn) return;
    this.drawn = shows;
    this.part.set(part.left, part.top, part.right - part.left, part.bottom - part.top);
    for (const { layer, factor } of needed) this.compose(layer, part, factor, size);
  }

  /** Begins anew when the graphics card has lost its pictures. */
  reload(): void {
    this.drawn = "";
    Object.values(this.layers).forEach(({ tiles }) => tiles.clear());
  }

  dispose(): void {
    for (const { tiles, target } of Object.values(this.layers)) {
      tiles.clear();
      target.dispose();
    }
    this.quad.geometry.dispose();
    this.quad.material.dispose();
  }

  private compose(layer: Layer, part: Part, factor: number, size: { x: number; y: number }): void {
    const { target, tiles, base } = layer;
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
