// A picture with the strokes that remarks speak of, and the numbers of the remarks on them.

import { useState } from "preact/hooks";
import { type Box, type Numbered, placeNumbers } from "../../strokes/numbers";
import { useSize } from "../../ui";

/** absent: drawn where a stroke should stand, but does not. */
export type Note = { lines: [number, number][][]; box: Box | null; absent: boolean };
export type Size = { width: number; height: number };

type Props = {
  title: string;
  picture: string;
  alt: string;
  /** Of the picture; without it, it is known once the picture is loaded. */
  size?: Size;
  /** One for each remark; null for one that speaks of nothing here. */
  notes: readonly (Note | null)[];
  active: number | null;
  onPoint: (k: number | null) => void;
  onPin: (k: number) => void;
};

const NUMBER = 11.5; // radius of a number in pixels, as in studio.css
const UNSEEN = 320; // pixels, until the sheet is measured

export function RemarkSheet({ title, picture, alt, size, notes, active, onPoint, onPin }: Props) {
  const [natural, setNatural] = useState<Size>(size ?? { width: 1, height: 1 });
  const [fit, shown] = useSize();
  const longer = Math.max(natural.width, natural.height);
  const frame = { width: shown.width || UNSEEN, height: shown.height || UNSEEN, radius: NUMBER, from: "middle" as const };
  const numbered = notes.flatMap((note, k) => (note ? [{ note, k }] : []));
  const places = placeNumbers(numbered.map(({ note }): Numbered => note), frame);
  const pointer = (k: number) => ({
    onPointerEnter: (event: PointerEvent) => event.pointerType !== "touch" && onPoint(k),
    onPointerLeave: () => onPoint(null),
    onClick: () => onPin(k),
  });
  return (
    <figure class="sheet-figure">
      <figcaption>{title}</figcaption>
      <div class={`sheet${active === null ? "" : " pointing"}`}>
        <div class="sheet-fit" ref={fit} style={{ width: `${(100 * natural.width) / longer}%`, height: `${(100 * natural.height) / longer}%` }}>
          <img src={picture} alt={alt} onLoad={({ currentTarget: { naturalWidth, naturalHeight } }) => size || setNatural({ width: naturalWidth, height: naturalHeight })} />
          <svg viewBox="0 0 1 1" preserveAspectRatio="none" aria-hidden="true">
            {numbered.map(({ note, k }) => <Outline key={k} note={note} on={active === k} />)}
            {numbered.map(({ note, k }) => <g key={k} class="outline-reach" {...pointer(k)}>{note.lines.map((line, n) => <polyline key={n} points={svgPoints(line)} />)}</g>)}
            {places.map(({ x, y, tether }, n) => tether && <path key={n} class="remark-tether" d={`M${tether[0]} ${tether[1]}L${x} ${y}`} />)}
          </svg>
          {numbered.map(({ k }, n) => (
            <button
              key={k} type="button" tabIndex={-1} aria-hidden="true" class={`remark-badge${active === k ? " on" : ""}`}
              style={{ left: `${100 * places[n]!.x}%`, top: `${100 * places[n]!.y}%` }} {...pointer(k)}
            >
              {k + 1}
            </button>
          ))}
        </div>
      </div>
    </figure>
  );
}

function Outline({ note, on }: { note: Note; on: boolean }) {
  const state = `outline${on ? " on" : ""}${note.absent ? " absent" : ""}`;
  if (note.box) {
    const [x0, y0, x1, y1] = note.box;
    return <rect class={`${state} region`} x={x0} y={y0} width={x1 - x0} height={y1 - y0} />;
  }
  return (
    <g class={state}>
      {note.lines.map((line, k) => <polyline key={k} class="outline-halo" points={svgPoints(line)} />)}
      {note.lines.map((line, k) => <polyline key={k} points={svgPoints(line)} />)}
    </g>
  );
}

const svgPoints = (line: readonly (readonly [number, number])[]): string => line.map(([x, y]) => `${x},${y}`).join(" ");
