// Level, score, parts of the mark and what it is based on; or why there is no mark.

import type { ComponentChildren } from "preact";
import { language, localize } from "../../i18n";
import { t } from "../../i18n/studio";
import type { Attempt, Mark } from "../../types";
import { ScoreBand } from "./ScoreBand";

export function Verdict({ attempt, remedy }: { attempt: Attempt; remedy?: ComponentChildren }) {
  const { mark } = attempt;
  if (mark.refused) return <Refused mark={mark} kept={attempt.id !== null} remedy={remedy} />;
  const teacher = attempt.teacher_marks.at(-1)?.mark ?? null;
  return (
    <section class="verdict panel" aria-labelledby="verdict-title">
      <div class="verdict-head">
        <div>
          <h2 id="verdict-title" class="visually-hidden">
            {t("mark")}
          </h2>
          <p class="verdict-score">
            <strong>{mark.score?.toFixed(0)}</strong> <span>/ 100</span>
          </p>
          {mark.interval && (
            <p class="note">{t("interval", { low: mark.interval[0].toFixed(0), high: mark.interval[1].toFixed(0) })}</p>
          )}
        </div>
        <Standing mark={mark} />
      </div>
      <ScoreBand mark={mark} teacher={teacher} />
      {attempt.kind === "simulated" && <p class="simulated">{t("simulated")}</p>}
      <Parts mark={mark} />
      <RestsOn mark={mark} />
    </section>
  );
}

/** Where the copy stands among learners' copies, and its level; the level alone in marks that do not know the former. */
export function Standing({ mark }: { mark: Pick<Mark, "level" | "level_text" | "percentile"> }) {
  if (!mark.level) return null;
  const tenths = mark.percentile == null ? null : Math.round(mark.percentile / 10);
  return (
    <div class="standing">
      {tenths !== null && (
        <>
          <span class="standing-row" aria-hidden="true">
            {Array.from({ length: 10 }, (_, k) => <i key={k} class={k < tenths ? "passed" : ""} />)}
          </span>
          <p>{t(tenths <= 0 ? "standsLowest" : tenths >= 10 ? "standsHighest" : "stands", { n: tenths })}</p>
        </>
      )}
      <p class="note">{t("levelIs", { level: localize(mark.level_text) })}</p>
    </div>
  );
}

function Parts({ mark }: { mark: Mark }) {
  return (
    <dl class="parts">
      {mark.parts.map((part) => (
        <div key={part.name}>
          <dt>
            {part.zh}
            {language.value === "en" && <span> {part.en}</span>}
          </dt>
          <dd>
            <meter min={0} max={100} value={part.score} aria-label={localize(part)} />
            <b>{part.score.toFixed(0)}</b>
            <p class="note">{localize(part.meaning)}</p>
          </dd>
        </div>
      ))}
    </dl>
  );
}

function RestsOn({ mark }: { mark: Mark }) {
  return (
    <div class="rests">
      <p class="note">{t("estimate")}</p>
      {mark.deduction_note && <p class="note">{localize(mark.deduction_note)}</p>}
      {mark.interval_note && <p class="note">{localize(mark.interval_note)}</p>}
      {mark.calibration && <p class="note">{t("calibrated", { by: mark.calibration })}</p>}
      {mark.source_text && <p class="note">{localize(mark.source_text)}</p>}
      {mark.sim_paper !== null && (
        <details>
          <summary>{t("more")}</summary>
          <p class="note">{t("simPaper", { value: mark.sim_paper.toFixed(1) })}</p>
          {mark.similarity !== null && <p class="note">{t("similarity", { value: mark.similarity.toFixed(3) })}</p>}
          {mark.pose && <p class="note">{t("pose", poseWords(mark.pose))}</p>}
          <p class="note">{t("seconds", { value: mark.seconds.toFixed(2) })}</p>
        </details>
      )}
    </div>
  );
}

export const poseWords = (pose: NonNullable<Mark["pose"]>) => ({
  angle: signed(pose.angle, 1),
  scale: (100 * pose.scale).toFixed(0),
  x: signed(100 * pose.shift[0], 1),
  y: signed(100 * pose.shift[1], 1),
});

const signed = (value: number, digits: number): string => `${value >= 0 ? "+" : "−"}${Math.abs(value).toFixed(digits)}`;

/** kept: a copy that its writer has kept without a mark; there is nothing left to advise. */
function Refused({ mark, kept, remedy }: { mark: Mark; kept: boolean; remedy: ComponentChildren }) {
  return (
    <section class="verdict refused panel" aria-labelledby="verdict-title">
      <h2 id="verdict-title">{t(kept ? "unmarkedTitle" : "refusedTitle")}</h2>
      <p>{localize(mark.refused)}</p>
      {!kept && !mark.refused?.turned_by && <p class="note">{t(mark.refused?.code === "another character" ? "refusedOther" : "refusedAdvice")}</p>}
      {remedy}
    </section>
  );
}
