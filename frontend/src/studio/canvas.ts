// A canvas that has as many pixels as the screen has under it.

import { useEffect, useState } from "preact/hooks";
import type { RefObject } from "preact";

const FINE = 2; // pixels of a canvas to one of a coarse screen: edges of many footprints in one path are hard otherwise

/** Side in pixels of the canvas in a square element; 0 until it is on the page. */
export function useSide(element: RefObject<HTMLElement | null>): number {
  const [side, setSide] = useState(0);
  useEffect(() => {
    const box = element.current;
    if (!box) return;
    const measure = () => setSide(Math.round(box.clientWidth * Math.max(FINE, devicePixelRatio || 1)));
    measure();
    const watch = new ResizeObserver(measure);
    watch.observe(box);
    addEventListener("resize", measure); // a change of zoom alone
    return () => {
      watch.disconnect();
      removeEventListener("resize", measure);
    };
  }, []);
  return side;
}

/** The canvas, cleared and of this side; null before it can be drawn on. */
export function cleared(canvas: HTMLCanvasElement | null, side: number): CanvasRenderingContext2D | null {
  if (!canvas || !side) return null;
  if (canvas.width !== side) canvas.width = canvas.height = side;
  const context = canvas.getContext("2d");
  context?.setTransform(1, 0, 0, 1, 0, 0);
  context?.clearRect(0, 0, side, side);
  return context;
}

/** A colour of the page's tokens, as a canvas needs it. */
export const token = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
