// A photograph as a canvas: upright, turned, continued by paper where the crop needs more, and cropped.

import type { Square } from "./crop";
import { firstCrop, type CropReason, type MasterShape } from "./firstCrop";
import { COPY_SIDE, type InkParts, type Raster } from "./photoInk";

/** A photograph, with its ink. `ink` is in pixels of a small copy: one of them is `scale` pixels of the canvas, its corner is at `corner`. */
/** blob: the photograph as a file, as the service is sent it. */
export type Photo = { canvas: HTMLCanvasElement; url: string; blob: Blob; ink: InkParts; scale: number; corner: { x: number; y: number } };
export type OpenedPhoto = { photo: Photo; square: Square; reason: CropReason };

const MAX_PHOTO_SIDE = 2400; // pixels of the longer side of the photograph while cropping
const MAX_CELL_SIDE = 1200; // pixels of the side of the cell that is sent
const STOPS = 8; // along an edge, where the colour of the paper beyond it is taken
const STRIP = 0.02; // of the longer side: so deep into the picture

/** The file's picture, upright (browsers apply EXIF when an image is drawn) and not larger than MAX_PHOTO_SIDE. */
export async function upright(file: Blob): Promise<HTMLCanvasElement> {
  const url = URL.createObjectURL(file);
  try {
    const image = new Image();
    image.src = url;
    await image.decode();
    const shrink = Math.min(1, MAX_PHOTO_SIDE / Math.max(image.naturalWidth, image.naturalHeight));
    return drawCanvas(image.naturalWidth * shrink, image.naturalHeight * shrink, (context, width, height) => {
      context.fillStyle = "#fff";
      context.fillRect(0, 0, width, height); // transparent parts become paper
      context.drawImage(image, 0, 0, width, height);
    });
  } finally {
    URL.revokeObjectURL(url);
  }
}

/** A canvas turned clockwise; degrees: a multiple of 90. */
export function turned(canvas: HTMLCanvasElement, degrees: number): HTMLCanvasElement {
  const quarters = ((Math.round(degrees / 90) % 4) + 4) % 4;
  const [width, height] = quarters % 2 ? [canvas.height, canvas.width] : [canvas.width, canvas.height];
  return drawCanvas(width, height, (context) => {
    context.translate(width / 2, height / 2);
    context.rotate((quarters * Math.PI) / 2);
    context.drawImage(canvas, -canvas.width / 2, -canvas.height / 2);
  });
}

/** A photograph with its first crop, continued by paper where that reaches beyond it. */
export async function openPhoto(canvas: HTMLCanvasElement, master: MasterShape | null): Promise<OpenedPhoto> {
  const raster = smallCopy(canvas);
  const { square: found, reason, ink } = firstCrop(raster, master);
  const scale = canvas.width / raster.width;
  const square = { x: found.x * scale, y: found.y * scale, side: found.side * scale };
  const beyond = {
    left: Math.ceil(Math.max(0, -square.x)),
    top: Math.ceil(Math.max(0, -square.y)),
    right: Math.ceil(Math.max(0, square.x + square.side - canvas.width)),
    bottom: Math.ceil(Math.max(0, square.y + square.side - canvas.height)),
  };
  const whole = Object.values(beyond).some(Boolean) ? onMorePaper(canvas, beyond) : canvas;
  const blob = await blobOf(whole, "image/jpeg");
  const url = URL.createObjectURL(blob);
  const corner = { x: beyond.left, y: beyond.top };
  return { photo: { canvas: whole, url, blob, ink, scale, corner }, square: { x: square.x + corner.x, y: square.y + corner.y, side: square.side }, reason };
}

export const cropToBlob = (photo: HTMLCanvasElement, { x, y, side }: Square): Promise<Blob> => {
  const to = Math.min(MAX_CELL_SIDE, Math.round(side));
  return blobOf(drawCanvas(to, to, (context) => context.drawImage(photo, x, y, side, side, 0, 0, to, to)), "image/png");
};

function smallCopy(canvas: HTMLCanvasElement): Raster {
  const shrink = Math.min(1, COPY_SIDE / Math.max(canvas.width, canvas.height));
  const small = drawCanvas(canvas.width * shrink, canvas.height * shrink, (context, width, height) => context.drawImage(canvas, 0, 0, width, height));
  return { data: small.getContext("2d")!.getImageData(0, 0, small.width, small.height).data, width: small.width, height: small.height };
}

type Edge = "left" | "right" | "top" | "bottom";

/** A picture on paper that has, beyond each edge, the colours of the paper along that edge. */
function onMorePaper(canvas: HTMLCanvasElement, beyond: Record<Edge, number>): HTMLCanvasElement {
  const { left, top, right, bottom } = beyond;
  return drawCanvas(canvas.width + left + right, canvas.height + top + bottom, (context, width, height) => {
    for (const edge of ["top", "bottom", "left", "right"] as const) {
      if (!beyond[edge]) continue;
      const lying = edge === "top" || edge === "bottom";
      const gradient = lying ? context.createLinearGradient(left, 0, left + canvas.width, 0) : context.createLinearGradient(0, top, 0, top + canvas.height);
      paperAlong(canvas, edge).forEach((colour, k) => gradient.addColorStop((k + 0.5) / STOPS, colour));
      context.fillStyle = gradient;
      if (lying) context.fillRect(0, edge === "top" ? 0 : height - bottom, width, beyond[edge]);
      else context.fillRect(edge === "left" ? 0 : width - right, 0, beyond[edge], height);
    }
    context.drawImage(canvas, left, top);
  });
}

/** The colour of the paper at STOPS places along an edge: the median of the lighter half, which is not ink. */
function paperAlong(canvas: HTMLCanvasElement, edge: Edge): string[] {
  const lying = edge === "top" || edge === "bottom";
  const deep = Math.max(1, Math.min(lying ? canvas.height : canvas.width, Math.round(STRIP * Math.max(canvas.width, canvas.height))));
  const context = canvas.getContext("2d")!;
  return Array.from({ length: STOPS }, (_, k) => {
    const length = lying ? canvas.width : canvas.height;
    const from = Math.min(length - 1, Math.floor((k * length) / STOPS));
    const long = Math.max(1, Math.floor(length / STOPS));
    const { data } = lying
      ? context.getImageData(from, edge === "top" ? 0 : canvas.height - deep, long, deep)
      : context.getImageData(edge === "left" ? 0 : canvas.width - deep, from, deep, long);
    const pixels = Array.from({ length: data.length / 4 }, (_, p) => [data[4 * p]!, data[4 * p + 1]!, data[4 * p + 2]!] as const);
    pixels.sort((a, b) => a[0] + a[1] + a[2] - b[0] - b[1] - b[2]);
    return `rgb(${pixels[Math.floor(0.75 * (pixels.length - 1))]!.join(" ")})`;
  });
}

type Draw = (context: CanvasRenderingContext2D, width: number, height: number) => void;

function drawCanvas(width: number, height: number, draw: Draw): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(width));
  canvas.height = Math.max(1, Math.round(height));
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) throw new Error("expected a canvas to draw on, got none");
  context.imageSmoothingQuality = "high";
  draw(context, canvas.width, canvas.height);
  return canvas;
}

const blobOf = (canvas: HTMLCanvasElement, type: string): Promise<Blob> =>
  new Promise((done, fail) => canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("expected a picture"))), type, 0.93));
