// A dialog to search for a work and choose it.

import { useState } from "preact/hooks";
import { get, query } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { Page, WorkCard } from "../types";
import { Dialog, ErrorMessage, useLoaded } from "../ui";

const MAX_RESULTS = 24;

/** masters: only works that are a character. collection: only works of it. */
type Props = { title: string; not?: string; masters?: boolean; collection?: string; onClose: () => void; onChoose: (work: WorkCard) => void };

export function WorkPicker({ title, not, masters, collection, onClose, onChoose }: Props) {
  const [q, setQ] = useState("");
  const loaded = useLoaded((signal) => get<Page<WorkCard>>(`api/works${query({ q: q.trim(), limit: MAX_RESULTS, masters: masters ? "true" : null, collection: collection ?? null })}`, signal), q.trim());
  return (
    <Dialog title={title} onClose={onClose}>
      <input type="search" aria-label={t("search")} placeholder={t("searchHint")} value={q} onInput={(event) => setQ(event.currentTarget.value)} />
      {loaded.error ? <ErrorMessage error={loaded.error} retry={loaded.retry} /> : null}
      <ul class="picker">
        {(loaded.value?.items ?? []).filter((work) => work.id !== not).map((work) => (
          <li key={work.id}>
            <button type="button" class="quiet" onClick={() => onChoose(work)}>
              <img src={work.thumb} alt="" width="96" height="96" loading="lazy" />
              <span>{localize(work.title)}</span>
            </button>
          </li>
        ))}
      </ul>
      {loaded.value?.total === 0 && <p class="note">{t("nothing")}</p>}
    </Dialog>
  );
}
