// A photograph, and its cell: a square that begins on the printed cell or around the writing, or four corners, without perspective.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Grid, WorkCard } from "../types";
import { masterShape } from "./canvas";
import { PickPhoto } from "../sheets/PickPhoto";
import { SheetFound } from "../sheets/SheetFound";
import { ErrorMessage, useDelayed, useLoaded } from "../ui";
import { CornerBox } from "./CornerBox";
import { type Corners, cornersOf, cornersText, isCell, TURN, turnCorners } from "./corners";
import type { Square } from "./crop";
import { CropBox, cutOff } from "./CropBox";
import { cropToBlob, openPhoto, type OpenedPhoto, type Photo, turned, upright } from "./photoCanvas";
import { flattenCell, lookAt } from "./photographed";

const TYPES = "image/png,image/jpeg,image/webp";
const PREVIEW_DELAY_MS = 300; // after a corner was moved

export type MakeCell = () => Promise<Blob>;
type Props = {
  grid: Grid;
  work: WorkCard;
  /**
   * Called with a function that crops the cell, whenever the square changes; with null while there is no photograph,
   * or while another one, or the same turned, is being opened.
   * framed: the square is the printed cell.
   */
  onCell: (make: MakeCell | null, framed: boolean) => void;
  /** Called once with a function that turns the photograph clockwise and crops it anew. */
  onTurnable?: (turn: (degrees: number) => void) => void;
};

export function CropPhoto({ grid, work, onCell, onTurnable }: Props) {
  const [opened, setOpened] = useState<OpenedPhoto | null>(null);
  const [square, setSquare] = useState<Square | null>(null);
  const [trouble, setTrouble] = useState(false);
  const [opening, setOpening] = useState(false);
  const plain = useRef<HTMLCanvasElement | null>(null); // the photograph as it is turned, without more paper
  const [corners, setCorners] = useState<Corners | null>(null); // dragged each by itself; null: the square
  const [turnedBy, setTurnedBy] = useState(0); // degrees of the fine turn
  const photo = opened?.photo ?? null;
  const flat = useMemo(() => (square && (corners || turnedBy) ? turnCorners(corners ?? cornersOf(square), turnedBy) : null), [square, corners, turnedBy]);
  const seen = useLook(opened, (found) => setCorners((old) => old ?? found));
  const framed = corners ? opened?.reason === "grid" || seen.cell : opened?.reason === "grid" && square === opened.square && !turnedBy;
  const order = useRef(0); // of photographs and turns, the last that was begun
  const done = useRef(0); // and the last that ended
  useEffect(() => {
    // the one opened before may be drawn while the next is on its way already: `opening` does not know of that yet
    if (!opening && done.current === order.current) onCell(photo && square ? () => (flat ? flattenCell(photo.blob, flat) : cropToBlob(photo.canvas, square)) : null, framed);
  }, [photo, square, flat, opening]);
  useEffect(() => () => void (photo && URL.revokeObjectURL(photo.url)), [photo]);
  const shape = useRef<ReturnType<typeof masterShape> | null>(null);
  const take = async (drawn: HTMLCanvasElement | Promise<HTMLCanvasElement>) => {
    const mine = ++order.current;
    onCell(null, false); // at once: what stands here now is no longer what is to be marked
    setOpening(true);
    try {
      const canvas = await drawn;
      plain.current = canvas;
      const next = await openPhoto(canvas, await (shape.current ??= masterShape(work)));
      if (mine !== order.current) return URL.revokeObjectURL(next.photo.url); // another photograph, or a turn, came after it
      setOpened(next);
      setSquare(next.square);
      setCorners(null);
      setTurnedBy(0);
      setTrouble(false);
    } catch {
      if (mine === order.current) setTrouble(true);
    } finally {
      if (mine === order.current) {
        done.current = mine;
        setOpening(false);
      }
    }
  };
  const file = useRef<File | null>(null);
  const open = ([chosen]: File[]) => {
    if (!chosen) return;
    file.current = chosen;
    void take(upright(chosen));
  };
  const turn = (degrees: number) => {
    if (!plain.current) return;
    plain.current = turned(plain.current, degrees);
    void take(plain.current);
  };
  useEffect(() => onTurnable?.(turn), []);
  return (
    <div class="photo">
      {opened && square ? (
        <>
          {seen.sheet && <SheetFound file={file.current} />}
          {corners || turnedBy ? (
            <CornerBox photo={opened.photo} corners={flat!} grid={grid} onCorners={(moved) => setCorners(turnCorners(moved, -turnedBy))} />
          ) : (
            <CropBox photo={opened.photo} square={square} grid={grid} onSquare={setSquare} />
          )}
          <CornerTools
            apart={corners !== null} turnedBy={turnedBy} onTurn={setTurnedBy}
            onApart={(apart) => (setCorners(apart ? cornersOf(square) : null), !apart && setTurnedBy(0))}
          />
          {flat ? <FlatPreview photo={opened.photo} corners={flat} /> : <CropNotes opened={opened} square={square} />}
        </>
      ) : (
        <div class="photo-empty">
          <p>{t("photoHint")}</p>
        </div>
      )}
      {trouble && (
        <p class="trouble" role="alert">
          {t("photoTrouble")}
        </p>
      )}
      <div class="row">
        <PickPhoto label={t("takePhoto")} camera types={TYPES} onFiles={open} />
        <PickPhoto label={t("choosePhoto")} types={TYPES} onFiles={open} />
        {photo && (
          <>
            <button type="button" class="quiet" onClick={() => turn(-90)}>
              ↺ {t("turnLeft")}
            </button>
            <button type="button" class="quiet" onClick={() => turn(90)}>
              ↻ {t("turnRight")}
            </button>
          </>
        )}
      </div>
    </div>
  );
}

const SKEWED = 0.025; // of the side, by which a corner lies beside that of a square from which the cell is not one

/** Asks the service about a photograph, once: whether it is of a sheet, and whether there is a printed cell that is no square. */
function useLook(opened: OpenedPhoto | null, onSkewed: (corners: Corners) => void): { sheet: boolean; cell: boolean } {
  const [seen, setSeen] = useState({ sheet: false, cell: false });
  useEffect(() => {
    setSeen({ sheet: false, cell: false });
    if (!opened) return;
    let current = true;
    const { photo, square, reason } = opened;
    const begun = cornersOf(square);
    lookAt(photo.blob, reason === "picture" ? null : begun, reason === "ink").then(
      ({ sheet, cell }) => {
        if (!current) return;
        const off = cell?.map(([x, y], k) => Math.hypot(x - begun[k]![0], y - begun[k]![1])) ?? [0];
        const skewed = cell !== null && isCell(cell) && Math.max(...off) > SKEWED * square.side;
        setSeen({ sheet, cell: skewed });
        if (skewed) onSkewed(cell);
      },
      () => undefined, // without it the square stays
    );
    return () => {
      current = false;
    };
  }, [opened]);
  return seen;
}

type ToolProps = { apart: boolean; turnedBy: number; onApart: (apart: boolean) => void; onTurn: (degrees: number) => void };

function CornerTools({ apart, turnedBy, onApart, onTurn }: ToolProps) {
  return (
    <div class="corner-tools">
      <label class="check">
        <input type="checkbox" checked={apart} onChange={(event) => onApart(event.currentTarget.checked)} />
        <span>{t("cornersApart")}</span>
      </label>
      <label class="slider">
        <span>{t("fineTurn")}</span>
        <input
          type="range" min={-TURN.most} max={TURN.most} step={TURN.step} value={turnedBy} aria-valuetext={t("degrees", { n: turnedBy.toFixed(1) })}
          onInput={(event) => onTurn(Number(event.currentTarget.value))}
        />
        <span class="number">{t("degrees", { n: turnedBy.toFixed(1) })}</span>
      </label>
    </div>
  );
}

/** The cell as it will be marked, without perspective. */
function FlatPreview({ photo, corners }: { photo: Photo; corners: Corners }) {
  const rested = useDelayed(corners, PREVIEW_DELAY_MS);
  const { value, error } = useLoaded(() => flattenCell(photo.blob, rested), `${photo.url} ${cornersText(rested)}`);
  const url = useMemo(() => (value ? URL.createObjectURL(value) : null), [value]);
  useEffect(() => () => void (url && URL.revokeObjectURL(url)), [url]);
  return (
    <div class="crop-notes">
      <p class="note">{t("cornersHint")}</p>
      {error ? <ErrorMessage error={error} /> : null}
      {url && (
        <figure class="flat-cell">
          <img src={url} alt={t("flatAlt")} width="200" height="200" />
          <figcaption class="note">{t("flatNote")}</figcaption>
        </figure>
      )}
    </div>
  );
}

/** What the crop cuts off; else where it came from, until it is moved; and how to move it. */
function CropNotes({ opened, square }: { opened: OpenedPhoto; square: Square }) {
  const cuts = useMemo(() => cutOff(opened.photo, square).length > 0, [opened, square]);
  const reason = { grid: "cropGrid", picture: "cropPicture", ink: "cropInk" } as const;
  return (
    <div class="crop-notes">
      <p class={cuts ? "crop-cuts" : "note"} role="status">
        {cuts ? t("cropCuts") : square === opened.square ? t(reason[opened.reason]) : ""}
      </p>
      <p class="note">{t("cropHint")}</p>
    </div>
  );
}
