// The cell to write in: grid and faint master below, ink above. It handles pointers; ink/brush.ts gives strokes their
// shape.

import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Grid, WorkCard } from "../types";
import { clearedContext, cssVariable, masterInkLayer, useCanvasSide } from "./canvas";
import { GridLines } from "./grids";
import { paintStrokes } from "./ink/painting";
import { acceptPointer, NO_POINTER, pointerKind, type PointerState, releasePointer, sampleOf } from "./ink/pointers";
import type { Stroke } from "./ink/strokes";
import { fitInSquare } from "./mark/alignment";

type Props = {
  strokes: readonly Stroke[];
  size: number;
  ink: number;
  grid: Grid;
  work: WorkCard;
  /** Opacity of the master below, 0-1. */
  ghost: number;
  onStroke: (stroke: Stroke) => void;
  /** Called with true when a stroke begins and false when it ends. */
  onWriting?: (down: boolean) => void;
};

export function WritingCell({ strokes, size, ink, grid, work, ghost, onStroke, onWriting }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const dry = useRef<HTMLCanvasElement>(null);
  const wet = useRef<HTMLCanvasElement>(null);
  const side = useCanvasSide(box);
  const pen = useRef<{ pointers: PointerState; stroke: Stroke | null; cell: DOMRect | null; began: number; frame: number }>({
    pointers: NO_POINTER, stroke: null, cell: null, began: 0, frame: 0,
  });
  useEffect(() => drawStrokes(dry.current, strokes, side), [strokes, side]);
  useEffect(() => () => cancelAnimationFrame(pen.current.frame), []);

  const redraw = () => {
    const now = pen.current;
    now.frame ||= requestAnimationFrame(() => {
      now.frame = 0;
      drawStrokes(wet.current, now.stroke ? [now.stroke] : [], side);
    });
  };
  const begin = (event: PointerEvent) => {
    const now = pen.current;
    const { begins, pointers } = acceptPointer(now.pointers, event);
    now.pointers = pointers;
    if (!begins) return;
    event.preventDefault();
    const cell = event.currentTarget as HTMLElement;
    try {
      cell.setPointerCapture(event.pointerId);
    } catch {
      // the pointer is already gone; its stroke ends with the next event
    }
    now.cell = dry.current!.getBoundingClientRect();
    now.began = event.timeStamp;
    now.stroke = { hand: pointerKind(event.pointerType), size, ink, points: [sampleOf(event, now.cell, now.began)] };
    onWriting?.(true);
    redraw();
  };
  const move = (event: PointerEvent) => {
    const now = pen.current;
    if (event.pointerId !== now.pointers.active || !now.stroke || !now.cell) return;
    const all = event.getCoalescedEvents?.() ?? [];
    for (const one of all.length ? all : [event]) now.stroke.points.push(sampleOf(one, now.cell, now.began));
    redraw();
  };
  const end = (event: PointerEvent) => {
    const now = pen.current;
    if (event.pointerId !== now.pointers.active) return;
    now.pointers = releasePointer(now.pointers, event.pointerId);
    const stroke = now.stroke;
    now.stroke = null;
    onWriting?.(false);
    redraw();
    if (!stroke || event.type === "pointercancel" || !now.cell) return;
    const last = stroke.points.at(-1)!;
    const up = sampleOf(event, now.cell, now.began);
    stroke.points.push([up[0], up[1], up[2], last[3], last[4], last[5]]); // a lifted pen reports pressure 0
    drawStrokes(dry.current, [...strokes, stroke], side); // before the next frame, so that nothing flickers
    onStroke(stroke);
  };
  return (
    <div
      ref={box}
      class="cell"
      role="img"
      aria-label={t("cell", { count: strokes.length })}
      onPointerDown={begin}
      onPointerMove={move}
      onPointerUp={end}
      onPointerCancel={end}
      onContextMenu={(event) => event.preventDefault()}
    >
      <GridLines grid={grid} />
      <TracedMaster work={work} opacity={ghost} side={side} />
      <canvas ref={dry} aria-hidden="true" />
      <canvas ref={wet} aria-hidden="true" />
    </div>
  );
}

function drawStrokes(canvas: HTMLCanvasElement | null, strokes: readonly Stroke[], side: number): void {
  const context = clearedContext(canvas, side);
  if (!context) return;
  context.fillStyle = cssVariable("soot");
  paintStrokes(context, strokes, side);
}

/** The master in pale red, as on sheets for tracing. */
function TracedMaster({ work, opacity, side }: { work: WorkCard; opacity: number; side: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [layer, setLayer] = useState<HTMLCanvasElement | null>(null);
  const visible = opacity > 0;
  useEffect(() => {
    let current = true;
    if (visible) masterInkLayer(work, cssVariable("rule")).then((inkLayer) => current && setLayer(inkLayer), () => undefined);
    return () => {
      current = false;
    };
  }, [work.id, visible]);
  useEffect(() => {
    const context = clearedContext(canvas.current, side);
    if (!context || !layer) return;
    context.setTransform(...scaled(fitInSquare(work.width, work.height), side));
    context.drawImage(layer, 0, 0, 1, 1);
  }, [layer, side]);
  return <canvas ref={canvas} aria-hidden="true" style={{ opacity }} />;
}

const scaled = ([a, b, c, d, e, f]: ReturnType<typeof fitInSquare>, side: number) =>
  [a * side, b * side, c * side, d * side, e * side, f * side] as [number, number, number, number, number, number];

