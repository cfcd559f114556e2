// A card's picture under a lamp that follows the pointer, computed on a 2-D canvas in a few milliseconds.

import { decodeNormal, lampDirection, linearToSrgb, SHEEN, srgbToLinear, type Vec3, warmLamp } from "../viewer/shading";

export type CardImage = { width: number; height: number; linear: Float32Array; normals: Float32Array };

const DECODED = Float32Array.from({ length: 256 }, (_, v) => srgbToLinear(v / 255));
const CODES = 4095;
const ENCODED = Uint8Array.from({ length: CODES + 1 }, (_, v) => Math.round(linearToSrgb(v / CODES) * 255));
const ABOVE: Vec3 = [0, 0, 1];

export async function loadCardImage(thumb: string, normals: string): Promise<CardImage> {
  const [picture, normalMap] = await Promise.all([load(thumb), load(normals)]);
  const { naturalWidth: width, naturalHeight: height } = picture;
  const [colours, codes] = [pixels(picture, width, height), pixels(normalMap, width, height)];
  const card = { width, height, linear: new Float32Array(width * height * 3), normals: new Float32Array(width * height * 3) };
  for (let k = 0; k < width * height; k++) {
    const n = decodeNormal([codes[k * 4]! / 255, codes[k * 4 + 1]! / 255, codes[k * 4 + 2]! / 255]);
    for (let c = 0; c < 3; c++) {
      card.linear[k * 3 + c] = DECODED[colours[k * 4 + c]!]!;
      card.normals[k * 3 + c] = n[c]!;
    }
  }
  return card;
}

/** RGBA of the card under a lamp; `out` is width * height * 4. */
export function shadePixels(card: CardImage, light: Vec3, out: Uint8ClampedArray, sheen = SHEEN): void {
  const { linear, normals } = card;
  for (let k = 0; k < card.width * card.height; k++) {
    const at = k * 3;
    const albedo: Vec3 = [linear[at]!, linear[at + 1]!, linear[at + 2]!];
    const picture = warmLamp(albedo, [normals[at]!, normals[at + 1]!, normals[at + 2]!], light, ABOVE, sheen);
    for (let c = 0; c < 3; c++) out[k * 4 + c] = ENCODED[Math.round(picture[c]! * CODES)]!;
    out[k * 4 + 3] = 255;
  }
}

/** `measured`: a surface measured from photographs, shown without sheen. */
export function paintRelit(canvas: HTMLCanvasElement, card: CardImage, tilt: number, slant: number, measured = false): void {
  const context = canvas.getContext("2d");
  if (!context) return;
  if (canvas.width !== card.width || canvas.height !== card.height) Object.assign(canvas, { width: card.width, height: card.height });
  const image = context.createImageData(card.width, card.height);
  shadePixels(card, lampDirection(tilt, slant), image.data, measured ? 0 : SHEEN);
  context.putImageData(image, 0, 0);
}

async function load(url: string): Promise<HTMLImageElement> {
  const image = new Image();
  image.src = url;
  await image.decode();
  return image;
}

function pixels(image: HTMLImageElement, width: number, height: number): Uint8ClampedArray {
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) throw new Error("no 2-D canvas");
  context.imageSmoothingQuality = "high";
  context.drawImage(image, 0, 0, width, height);
  return context.getImageData(0, 0, width, height).data;
}
