// The score on its scale, with its interval and the zones of the four levels.

import { localize } from "../../i18n";
import { t } from "../../i18n/studio";
import type { Mark } from "../../types";

const LEVELS = ["bad", "medium", "good", "excellent"] as const;

export function ScoreBand({ mark, teacher }: { mark: Mark; teacher?: number | null }) {
  if (mark.score === null) return null;
  const [low, high] = mark.interval ?? [mark.score, mark.score];
  const label = t("bandLabel", { score: mark.score.toFixed(0), low: low.toFixed(0), high: high.toFixed(0) });
  return (
    <svg class="band" viewBox="0 0 320 64" role="img" aria-label={label}>
      <Levels mark={mark} />
      <rect class="band-axis" x={X(0)} y="31" width="300" height="2" />
      <rect class="band-interval" x={X(low)} y="25" width={Math.max(2, X(high) - X(low))} height="14" rx="7" />
      {[0, 25, 50, 75, 100].map((at) => (
        <text key={at} class="band-tick" x={X(at)} y="58">
          {at}
        </text>
      ))}
      <path class="band-needle" d={`M${X(mark.score)} 20v24`} />
      {teacher !== null && teacher !== undefined && (
        <path class="band-teacher" d={`M${X(teacher)} 21l6 -9h-12z`}>
          <title>{t("teacherSays", { mark: teacher })}</title>
        </path>
      )}
    </svg>
  );
}

const X = (score: number): number => 10 + 3 * Math.min(100, Math.max(0, score));

/** The zones of the levels, if the service sent their limits. */
function Levels({ mark }: { mark: Mark }) {
  if (!mark.cuts) return null;
  const edges = [0, mark.cuts.medium, mark.cuts.good, mark.cuts.excellent, 100];
  return (
    <g>
      {LEVELS.map((level, k) => (
        <g key={level} class={`band-level${level === mark.level ? " here" : ""}`}>
          <rect class={`band-zone zone-${k}`} x={X(edges[k]!)} y="18" width={X(edges[k + 1]!) - X(edges[k]!)} height="28" />
          <text x={(X(edges[k]!) + X(edges[k + 1]!)) / 2} y="11">
            {level === mark.level ? localize(mark.level_text) : t(level)}
          </text>
        </g>
      ))}
    </g>
  );
}
