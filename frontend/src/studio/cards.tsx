// Master and copy as pages of the studio show them: at the head of a page, large, or in a list.

import type { ComponentChildren } from "preact";
import { get } from "../api";
import { formatDateTime, localize } from "../i18n";
import { t } from "../i18n/studio";
import type { Attempt, Work, WorkCard } from "../types";
import { Facts, useLoaded } from "../ui";

/** The head of a page about one master: its thumbnail, which links to it in the gallery, and what stands beside. */
export function MasterHeader({ work, children }: { work: WorkCard; children: ComponentChildren }) {
  return (
    <header class="desk-head">
      <a class="desk-thumb" href={`#/works/${work.id}`}>
        <img src={work.thumb} alt={t("seeMaster")} width="72" height="72" />
      </a>
      <div>{children}</div>
    </header>
  );
}

/** The master as large as the page allows; its thumbnail until the picture is loaded. */
export function MasterPicture({ work, alt }: { work: WorkCard; alt: string }) {
  const loaded = useLoaded((signal) => get<Work>(`api/works/${encodeURIComponent(work.id)}`, signal), work.id);
  return <img class="sheet-picture" src={loaded.value?.files.picture ?? work.thumb} alt={alt} />;
}

/** A copy in a list: its picture, its mark, when it was written. counts: it is the one that counts for its task. */
export function AttemptCard({ attempt, title, counts = false }: { attempt: Attempt; title?: string; counts?: boolean }) {
  const { mark } = attempt;
  return (
    <a class="attempt-card" href={`#/attempts/${attempt.id}`}>
      {attempt.picture && <img src={attempt.picture} alt={t("copyAlt")} loading="lazy" width="200" height="200" />}
      <span>
        {title && <b>{title}</b>}
        <span class="attempt-score"><Facts items={mark.score === null ? [t("noMark")] : [mark.score.toFixed(0), localize(mark.level_text)]} /></span>
        <small class="note">{formatDateTime(attempt.created)}</small>
        {counts && <small class="attempt-counts">{t("counts")}</small>}
      </span>
    </a>
  );
}
