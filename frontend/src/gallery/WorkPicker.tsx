import { useState } from "preact/hooks";
import { get, query } from "../api";
import { say, words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import type { Page, WorkCard } from "../types";
import { Dialog, Trouble, useLoaded } from "../ui";

const t = words(table);
const SHOWN = 24;

type Props = { title: string; not?: string; onClose: () => void; onChoose: (work: WorkCard) => void };

export function WorkPicker({ title, not, onClose, onChoose }: Props) {
  const [q, setQ] = useState("");
  const found = useLoaded((signal) => get<Page<WorkCard>>(`/api/works${query({ q: q.trim(), limit: SHOWN })}`, signal), q.trim());
  return (
    <Dialog title={title} onClose={onClose}>
      <input type="search" aria-label={t("search")} placeholder={t("searchHint")} value={q} onInput={(event) => setQ(event.currentTarget.value)} />
      {found.error ? <Trouble error={found.error} again={found.again} /> : null}
      <ul class="picker">
        {(found.value?.items ?? []).filter((work) => work.id !== not).map((work) => (
          <li key={work.id}>
            <button type="button" class="quiet" onClick={() => onChoose(work)}>
              <img src={work.thumb} alt="" width="96" height="96" loading="lazy" />
              <span>{say(work.title)}</span>
            </button>
          </li>
        ))}
      </ul>
      {found.value?.total === 0 && <p class="note">{t("nothing")}</p>}
    </Dialog>
  );
}
