// The master beside the sheet: its picture, and the order of its strokes. On a phone it folds away above the sheet.

import { useState } from "preact/hooks";
import { localize } from "../i18n";
import { t } from "../i18n/studio";
import { hasStrokeOrder, StrokeOrder } from "../strokes/StrokeOrder";
import type { Work } from "../types";

const WIDE = "(min-width: 900px)"; // as in studio.css

/** marked: a mark stands below, so that the master folds away unless its reader has opened it. */
export function MasterBeside({ work, marked }: { work: Work; marked: boolean }) {
  const [chosen, setChosen] = useState<boolean | null>(null);
  const open = chosen ?? (!marked && matchMedia(WIDE).matches);
  const ordered = hasStrokeOrder(work);
  return (
    <details class="desk-master" open={open}>
      <summary onClick={(event) => (event.preventDefault(), setChosen(!open))}>{t(ordered ? "masterAndOrder" : "master")}</summary>
      {open && (
        <div class="master-beside">
          <img class="sheet-picture" src={work.files?.picture ?? work.thumb} alt={localize(work.title)} />
          {ordered && <StrokeOrder character={work.character} />}
        </div>
      )}
    </details>
  );
}
