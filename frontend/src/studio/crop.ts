// The square of a photograph that is cropped as the cell. All lengths in pixels of the photograph.

export type Square = { x: number; y: number; side: number };
export type Size = { width: number; height: number };
export type Handle = "nw" | "ne" | "sw" | "se";
export const HANDLES: Handle[] = ["nw", "ne", "sw", "se"];

export const MIN_SIDE = 32; // pixels; a smaller cell cannot be marked

export function moveSquare(square: Square, dx: number, dy: number, size: Size): Square {
  const clamp = (value: number, max: number) => Math.min(Math.max(0, value), Math.max(0, max));
  return {
    x: clamp(square.x + dx, size.width - square.side),
    y: clamp(square.y + dy, size.height - square.side),
    side: square.side,
  };
}

/** Moves the corner `handle` to (x, y), as near as a square within the picture allows; the opposite corner stays. */
export function resizeSquare(square: Square, handle: Handle, x: number, y: number, size: Size): Square {
  const [west, north] = [handle.endsWith("w"), handle.startsWith("n")];
  const fixed = { x: square.x + (west ? square.side : 0), y: square.y + (north ? square.side : 0) };
  const space = Math.min(west ? fixed.x : size.width - fixed.x, north ? fixed.y : size.height - fixed.y);
  const wanted = Math.max(west ? fixed.x - x : x - fixed.x, north ? fixed.y - y : y - fixed.y);
  const side = Math.min(space, Math.max(Math.min(MIN_SIDE, space), wanted));
  return { x: west ? fixed.x - side : fixed.x, y: north ? fixed.y - side : fixed.y, side };
}

/** Makes the square larger or smaller about its middle, within the picture. */
export function growSquare(square: Square, by: number, size: Size): Square {
  const side = Math.min(size.width, size.height, Math.max(MIN_SIDE, square.side + by));
  const shift = (square.side - side) / 2;
  return moveSquare({ x: square.x + shift, y: square.y + shift, side }, 0, 0, size);
}
