// Paints stamps on a canvas. The same strokes give the same picture on any screen.

import { BRUSH, type BrushSettings, brushStamps, type Stamp } from "./brush";
import type { Stroke } from "./strokes";

type Context = CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;

/** side: pixels of the cell. */
function paintStamps(context: Context, stamps: readonly Stamp[], side: number): void {
  context.beginPath();
  for (const { x, y, a, b, angle } of stamps) {
    context.moveTo(x * side + a * side * Math.cos(angle), y * side + a * side * Math.sin(angle));
    context.ellipse(x * side, y * side, Math.max(a * side, 0.25), Math.max(b * side, 0.25), angle, 0, 2 * Math.PI);
  }
  context.fill("nonzero");
}

export function paintStrokes(context: Context, strokes: readonly Stroke[], side: number, brush: BrushSettings = BRUSH): void {
  for (const stroke of strokes) paintStamps(context, brushStamps(stroke, brush), side);
}

const OVERSAMPLING = 2; // drawn larger and scaled down: otherwise edges of many stamps in one path are jagged

/** The picture to mark, black on white. side: pixels. */
export async function strokesPicture(strokes: readonly Stroke[], side = 512): Promise<Blob> {
  const large = blank(OVERSAMPLING * side);
  paintStrokes(large, strokes, OVERSAMPLING * side);
  const small = blank(side);
  small.imageSmoothingQuality = "high";
  small.drawImage(large.canvas, 0, 0, side, side);
  return new Promise((done, fail) =>
    small.canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("expected a picture, got none"))), "image/png"),
  );
}

/** A white canvas that draws in black. */
function blank(side: number): CanvasRenderingContext2D {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = side;
  const context = canvas.getContext("2d");
  if (!context) throw new Error("expected a canvas to draw on, got none");
  context.fillStyle = "#fff";
  context.fillRect(0, 0, side, side);
  context.fillStyle = "#000";
  return context;
}
