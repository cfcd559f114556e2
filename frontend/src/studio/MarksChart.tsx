// A chart of marks over time with their intervals, and the same as a table for screen readers.

import { formatDateTime, formatDay, formatTime } from "../i18n";
import { t } from "../i18n/studio";

const WIDE: ChartFrame = { width: 640, height: 240, left: 34, right: 16, top: 12, bottom: 30 };
const NARROW: ChartFrame = { ...WIDE, width: 340, height: 220 }; // for a phone, so that text keeps its size

export function MarksChart({ points, title }: { points: ScorePoint[]; title: string }) {
  const frame = innerWidth > 640 ? WIDE : NARROW;
  const dots = chartDots(points, frame);
  const days = new Set(dots.map(({ point }) => formatDay(point.created))).size;
  const when = days > 1 ? formatDay : formatTime;
  return (
    <figure class="curve">
      <svg viewBox={`0 0 ${frame.width} ${frame.height}`} role="group" aria-label={t("curveLabel", { title, count: dots.length })}>
        {[0, 25, 50, 75, 100].map((score) => (
          <g key={score} class="curve-line">
            <path d={`M${frame.left} ${scoreY(score, frame)}H${frame.width - frame.right}`} />
            <text x={frame.left - 8} y={scoreY(score, frame) + 4}>
              {score}
            </text>
          </g>
        ))}
        <path class="curve-band" d={intervalBand(dots)} />
        <path class="curve-way" d={linePath(dots)} />
        {dots.map(({ x, y, low, high, point }) => (
          <a key={point.id} href={`#/attempts/${point.id}`} aria-label={t("curvePoint", { score: point.score!.toFixed(0), day: formatDay(point.created) })}>
            {dots.length === 1 && <path class="curve-whisker" d={`M${x} ${low}V${high}`} />}
            <circle class="curve-hit" cx={x} cy={y} r="12" />
            <circle cx={x} cy={y} r="4.5" />
          </a>
        ))}
        {dots.length > 0 && (
          <g class="curve-days">
            <text x={frame.left} y={frame.height - 8}>
              {when(dots[0]!.point.created)}
            </text>
            {dots.length > 1 && (
              <text class="end" x={frame.width - frame.right} y={frame.height - 8}>
                {when(dots.at(-1)!.point.created)}
              </text>
            )}
          </g>
        )}
      </svg>
      <details>
        <summary>{t("asTable")}</summary>
        <table>
          <thead>
            <tr>
              <th scope="col">{t("when")}</th>
              <th scope="col" class="number">{t("mark")}</th>
              <th scope="col" class="number">{t("intervalShort")}</th>
            </tr>
          </thead>
          <tbody>
            {points.map((point) => (
              <tr key={point.id}>
                <th scope="row">
                  <a href={`#/attempts/${point.id}`}>{formatDateTime(point.created)}</a>
                </th>
                <td class="number">{point.score?.toFixed(0) ?? t("noMark")}</td>
                <td class="number">{point.interval ? point.interval.map((v) => v.toFixed(0)).join("–") : "–"}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </details>
    </figure>
  );
}

export type ScorePoint = { id: string; created: string; score: number | null; interval: [number, number] | null };
type ChartDot = { x: number; y: number; low: number; high: number; point: ScorePoint };
export type ChartFrame = { width: number; height: number; left: number; right: number; top: number; bottom: number };

export const scoreY = (score: number, frame: ChartFrame): number =>
  frame.height - frame.bottom - (Math.min(100, Math.max(0, score)) / 100) * (frame.height - frame.top - frame.bottom);

/** One dot for each attempt with a mark, evenly spaced in order, since practice comes in bursts. */
export function chartDots(points: readonly ScorePoint[], frame: ChartFrame): ChartDot[] {
  const marked = points.filter((point) => point.score !== null);
  const width = frame.width - frame.left - frame.right;
  return marked.map((point, k) => ({
    x: frame.left + (marked.length > 1 ? (k / (marked.length - 1)) * width : width / 2),
    y: scoreY(point.score!, frame),
    low: scoreY(point.interval?.[0] ?? point.score!, frame),
    high: scoreY(point.interval?.[1] ?? point.score!, frame),
    point,
  }));
}

export const linePath = (dots: readonly ChartDot[]): string => dots.map(({ x, y }, k) => `${k ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

/** The band of the intervals as one closed path. */
export function intervalBand(dots: readonly ChartDot[]): string {
  if (dots.length < 2) return "";
  const there = dots.map(({ x, high }, k) => `${k ? "L" : "M"}${x.toFixed(1)} ${high.toFixed(1)}`);
  const back = [...dots].reverse().map(({ x, low }) => `L${x.toFixed(1)} ${low.toFixed(1)}`);
  return `${[...there, ...back].join("")}Z`;
}
