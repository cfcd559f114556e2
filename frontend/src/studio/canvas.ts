// Canvases in the resolution of the screen, and the ink of a picture as a canvas in one colour.

import { useEffect, useState } from "preact/hooks";
import type { RefObject } from "preact";
import type { WorkCard } from "../types";
import type { MasterShape } from "./firstCrop";

const OVERSAMPLING = 2; // canvas pixels per pixel of a low-resolution screen: otherwise edges of many stamps in one path are jagged

/** Side in pixels of the canvas in a square element; 0 until the element is on the page. */
export function useCanvasSide(element: RefObject<HTMLElement | null>): number {
  const [side, setSide] = useState(0);
  useEffect(() => {
    const box = element.current;
    if (!box) return;
    const measure = () => setSide(Math.round(box.clientWidth * Math.max(OVERSAMPLING, devicePixelRatio || 1)));
    measure();
    const observer = new ResizeObserver(measure);
    observer.observe(box);
    addEventListener("resize", measure); // when only the zoom changes
    return () => {
      observer.disconnect();
      removeEventListener("resize", measure);
    };
  }, []);
  return side;
}

/** The context of a canvas, cleared and resized to `side`; null while there is nothing to draw on. */
export function clearedContext(canvas: HTMLCanvasElement | null, side: number): CanvasRenderingContext2D | null {
  if (!canvas || !side) return null;
  if (canvas.width !== side) canvas.width = canvas.height = side;
  const context = canvas.getContext("2d");
  context?.setTransform(1, 0, 0, 1, 0, 0);
  context?.clearRect(0, 0, side, side);
  return context;
}

/** A colour of the page's CSS variables, as a canvas needs it. */
export const cssVariable = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** The ink of a picture in one colour, transparent elsewhere. ink: dark in a picture, or white in a mask. side: longest side in pixels. */
export async function inkLayer(
  source: string | Blob, options: { ink: "dark" | "white"; colour: string; side?: number },
): Promise<HTMLCanvasElement> {
  const image = await loaded(source);
  const shrink = Math.min(1, (options.side ?? 768) / Math.max(image.naturalWidth, image.naturalHeight));
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(image.naturalWidth * shrink));
  canvas.height = Math.max(1, Math.round(image.naturalHeight * shrink));
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  const pixels = context.getImageData(0, 0, canvas.width, canvas.height);
  const value = (options.ink === "white" ? (v: number) => v : darkness(pixels.data));
  for (let k = 0; k < pixels.data.length; k += 4) {
    const light = 0.299 * pixels.data[k]! + 0.587 * pixels.data[k + 1]! + 0.114 * pixels.data[k + 2]!;
    pixels.data[k + 3] = value(light);
  }
  context.putImageData(pixels, 0, 0);
  context.globalCompositeOperation = "source-in";
  context.fillStyle = options.colour;
  context.fillRect(0, 0, canvas.width, canvas.height);
  return canvas;
}

/** Maps lightness 0-255 to ink 0-255, relative to the darkest and lightest parts, so that grey paper is not taken for ink. */
function darkness(data: Uint8ClampedArray): (light: number) => number {
  const lights: number[] = [];
  for (let k = 0; k < data.length; k += 4 * 7) lights.push(data[k + 1]!);
  lights.sort((a, b) => a - b);
  const [low, high] = [lights[Math.floor(lights.length * 0.01)] ?? 0, lights[Math.floor(lights.length * 0.9)] ?? 255];
  const [from, to] = [low + 0.65 * (high - low), low + 0.35 * (high - low)];
  return (light) => 255 * Math.min(1, Math.max(0, (from - light) / Math.max(1, from - to)));
}

function loaded(source: string | Blob): Promise<HTMLImageElement> {
  const url = typeof source === "string" ? source : URL.createObjectURL(source);
  return new Promise((done, fail) => {
    const image = new Image();
    image.onload = () => done(image);
    image.onerror = () => fail(new Error("expected a picture, got none"));
    image.src = url;
  }).finally(() => typeof source === "string" || setTimeout(() => URL.revokeObjectURL(url), 0)) as Promise<HTMLImageElement>;
}

export const masterInkLayer = (work: WorkCard, colour: string): Promise<HTMLCanvasElement> =>
  inkLayer(`api/works/${encodeURIComponent(work.id)}/files/mask`, { ink: "white", colour });

const MASK_SIDE = 256; // pixels of the longer side in which the master's ink is measured
const INKED = 128; // of 255: a pixel of the mask from here on is ink

/** Where the master's ink is, in fractions of the square around its cell; null where that cannot be seen. */
export async function masterShape(work: WorkCard): Promise<MasterShape | null> {
  try {
    const mask = await inkLayer(`api/works/${encodeURIComponent(work.id)}/files/mask`, { ink: "white", colour: "#000", side: MASK_SIDE });
    const { data, width, height } = mask.getContext("2d")!.getImageData(0, 0, mask.width, mask.height);
    const inked = Array.from({ length: width * height }, (_, k) => k).filter((k) => data[4 * k + 3]! >= INKED);
    if (!inked.length) return null;
    const [xs, ys] = [inked.map((k) => k % width), inked.map((k) => Math.floor(k / width))];
    const longer = Math.max(width, height);
    const least = (values: number[]) => values.reduce((a, b) => Math.min(a, b));
    const most = (values: number[]) => values.reduce((a, b) => Math.max(a, b)) + 1;
    const [dx, dy] = [(longer - width) / 2, (longer - height) / 2];
    return { x0: (least(xs) + dx) / longer, y0: (least(ys) + dy) / longer, x1: (most(xs) + dx) / longer, y1: (most(ys) + dy) / longer };
  } catch {
    return null;
  }
}
