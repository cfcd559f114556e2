// What an attempt changed against the one before: as a whole, by part, and what became of each fault.

import { formatDateTime, localize } from "../../i18n";
import { t } from "../../i18n/studio";
import type { FaultChange, Progress as Changed } from "../../types";

const BETTER: readonly FaultChange["status"][] = ["gone", "smaller"];
const SIGNS: Record<FaultChange["status"], string> = { gone: "✓", smaller: "↘", same: "＝", larger: "↗", turned: "⇄", new: "＋" };

export function Progress({ progress }: { progress: Changed }) {
  const { mark, parts, faults, previous } = progress;
  const better = faults.filter((fault) => BETTER.includes(fault.status));
  const open = faults.filter((fault) => !BETTER.includes(fault.status));
  return (
    <section class="progress panel" aria-labelledby="progress-title">
      <h2 id="progress-title">{t("progressTitle")}</h2>
      <p class={`progress-mark ${mark.change}`}>{localize(mark)}</p>
      <ul class="progress-parts">
        {parts.map((part) => (
          <li key={part.name} class={part.change}>
            {localize(part)} <span class="number">{part.before.toFixed(0)} → {part.after.toFixed(0)}</span> <b>{t(`change_${part.change}`)}</b>
          </li>
        ))}
      </ul>
      <FaultList title={t("gotBetter")} faults={better} />
      <FaultList title={t("notBetter")} faults={open} />
      {!faults.length && <p>{t("noFaultChange")}</p>}
      <p class="note">
        {t("progressNote")} <a href={`#/attempts/${previous.id}`}>{t("previousAttempt", { when: formatDateTime(previous.created) })}</a>
      </p>
    </section>
  );
}

function FaultList({ title, faults }: { title: string; faults: FaultChange[] }) {
  if (!faults.length) return null;
  return (
    <>
      <h3>{title}</h3>
      <ul class="progress-faults">
        {faults.map((fault, k) => (
          <li key={k} class={fault.status}>
            <span aria-hidden="true">{SIGNS[fault.status]}</span>
            <span>
              {localize(fault)}
              {fault.remark !== null && <small class="note"> {t("seeRemark", { k: fault.remark + 1 })}</small>}
            </span>
          </li>
        ))}
      </ul>
    </>
  );
}
