// A photograph, and its square to crop as the cell, which begins on the printed cell or around the writing.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { t } from "../i18n/studio";
import type { Grid, WorkCard } from "../types";
import { masterShape } from "./canvas";
import type { Square } from "./crop";
import { CropBox, cutOff } from "./CropBox";
import { cropToBlob, openPhoto, type OpenedPhoto, turned, upright } from "./photoCanvas";

const TYPES = "image/png,image/jpeg,image/webp";

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
  const photo = opened?.photo ?? null;
  const framed = opened?.reason === "grid" && square === opened.square;
  useEffect(() => {
    if (!opening) onCell(photo && square ? () => cropToBlob(photo.canvas, square) : null, framed);
  }, [photo, square, opening]);
  useEffect(() => () => void (photo && URL.revokeObjectURL(photo.url)), [photo]);
  const shape = useRef<ReturnType<typeof masterShape> | null>(null);
  const order = useRef(0);
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
      setTrouble(false);
    } catch {
      if (mine === order.current) setTrouble(true);
    } finally {
      if (mine === order.current) setOpening(false);
    }
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
          <CropBox photo={opened.photo} square={square} grid={grid} onSquare={setSquare} />
          <CropNotes opened={opened} square={square} />
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
        <PickFile label={t("takePhoto")} camera onFile={(file) => take(upright(file))} />
        <PickFile label={t("choosePhoto")} onFile={(file) => take(upright(file))} />
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

function PickFile({ label, camera, onFile }: { label: string; camera?: boolean; onFile: (file: File) => void }) {
  const pick = (event: Event & { currentTarget: HTMLInputElement }) => {
    const file = event.currentTarget.files?.[0];
    event.currentTarget.value = ""; // so that the same file can be chosen again
    if (file) onFile(file);
  };
  return (
    <label class={`button quiet pick${camera ? " camera" : ""}`}>
      {label}
      <input type="file" class="visually-hidden" accept={TYPES} {...(camera ? { capture: "environment" } : {})} onChange={pick} />
    </label>
  );
}
