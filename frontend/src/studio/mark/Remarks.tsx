// The numbered remarks, each with the strokes it speaks of in the master and in the copy, side by side.

import { useRef, useState } from "preact/hooks";
import { localize } from "../../i18n";
import { t } from "../../i18n/studio";
import type { Bilingual, Remark, Work, WorkCard } from "../../types";
import { get } from "../../api";
import { useLoaded } from "../../ui";
import { RemarkSheet } from "./RemarkSheet";

type Props = { praise?: Bilingual | null; remarks: Remark[]; picture: string | null; work: WorkCard };

export function Remarks({ praise, remarks, picture, work }: Props) {
  const [pointed, setPointed] = useState<number | null>(null);
  const [pinned, setPinned] = useState<number | null>(null);
  const list = useRef<HTMLOListElement>(null);
  const active = pointed ?? pinned;
  const toggle = (k: number) => setPinned(pinned === k ? null : k);
  const fromSheet = (k: number) => {
    toggle(k);
    // the list is below the sheets on a phone, and may be out of sight
    list.current?.children[k]?.scrollIntoView({ block: "nearest", behavior: "smooth" });
  };
  const shared = { active, onPoint: setPointed, onPin: fromSheet };
  return (
    <div class="remarks">
      <div class="remark-sheets">
        <MasterSheet work={work} remarks={remarks} {...shared} />
        {picture && <RemarkSheet title={t("copy")} picture={picture} alt={t("copyAlt")} notes={remarks.map(onCopy)} {...shared} />}
      </div>
      {praise && <p class="praise">{localize(praise)}</p>}
      {remarks.length ? (
        <ol class="remark-list" ref={list}>
          {remarks.map((remark, k) => (
            <RemarkLine key={k} remark={remark} number={k + 1} on={active === k} pinned={pinned === k} onPoint={(on) => setPointed(on ? k : null)} onPin={() => toggle(k)} />
          ))}
        </ol>
      ) : (
        <p>{t("noRemarks")}</p>
      )}
    </div>
  );
}

type LineProps = { remark: Remark; number: number; on: boolean; pinned: boolean; onPoint: (on: boolean) => void; onPin: () => void };

function RemarkLine({ remark, number, on, pinned, onPoint, onPin }: LineProps) {
  return (
    <li>
      <button
        type="button"
        class={`remark${on ? " on" : ""}`}
        aria-pressed={pinned}
        onPointerEnter={(event) => event.pointerType !== "touch" && onPoint(true)}
        onPointerLeave={() => onPoint(false)}
        onFocus={(event) => event.currentTarget.matches(":focus-visible") && onPoint(true)}
        onBlur={() => onPoint(false)}
        onClick={onPin}
      >
        <span class="remark-number">{number}</span>
        <span>
          {remark.name && <b>{localize(remark.name)}</b>}
          {localize(remark)}
        </span>
      </button>
    </li>
  );
}

type SheetProps = { work: WorkCard; remarks: Remark[]; active: number | null; onPoint: (k: number | null) => void; onPin: (k: number) => void };

function MasterSheet({ work, remarks, ...shared }: SheetProps) {
  const loaded = useLoaded((signal) => get<Work>(`api/works/${encodeURIComponent(work.id)}`, signal), work.id);
  const size = { width: work.width, height: work.height };
  return <RemarkSheet title={t("master")} picture={loaded.value?.files.picture ?? work.thumb} alt={localize(work.title)} size={size} notes={remarks.map(onMaster)} {...shared} />;
}

const onCopy = (remark: Remark) => ({ lines: remark.outline, box: remark.outline.length ? null : (remark.region ?? WHOLE), absent: remark.kind === "missing" });

/** What a remark speaks of in the master; nothing where that is not known, as in older marks, or not there. */
const onMaster = (remark: Remark) => (remark.master_outline?.length ? { lines: remark.master_outline, box: null, absent: false } : null);

const WHOLE = [0, 0, 1, 1] as const;
