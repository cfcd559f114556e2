// A copy in a list: its picture, its mark, when it was written.

import { say } from "../i18n";
import type { Attempt } from "../types";
import { moment } from "./Curve";
import { w } from "./say";

export function AttemptCard({ attempt, title }: { attempt: Attempt; title?: string }) {
  const { mark } = attempt;
  return (
    <a class="attempt-card" href={`#/attempts/${attempt.id}`}>
      {attempt.picture && <img src={attempt.picture} alt={w("copyAlt")} loading="lazy" width="200" height="200" />}
      <span>
        {title && <b>{title}</b>}
        <span class="attempt-score">{mark.score === null ? w("noMark") : `${mark.score.toFixed(0)} · ${say(mark.level_text)}`}</span>
        <small class="note">{moment(attempt.created)}</small>
      </span>
    </a>
  );
}
