// Marks over time, with their intervals; the same as a table for those who do not see it.

import { language } from "../i18n";
import { bandOf, dots, heightOf, pathOf, type Frame, type Point } from "./chart";
import { w } from "./say";

const WIDE: Frame = { width: 640, height: 240, left: 34, right: 16, top: 12, bottom: 30 };
const NARROW: Frame = { ...WIDE, width: 340, height: 220 }; // a phone: letters keep their size

export function Curve({ points, title }: { points: Point[]; title: string }) {
  const frame = innerWidth > 640 ? WIDE : NARROW;
  const found = dots(points, frame);
  const days = new Set(found.map(({ point }) => day(point.created))).size;
  const when = days > 1 ? day : hour;
  return (
    <figure class="curve">
      <svg viewBox={`0 0 ${frame.width} ${frame.height}`} role="group" aria-label={w("curveLabel", { title, count: found.length })}>
        {[0, 25, 50, 75, 100].map((score) => (
          <g key={score} class="curve-line">
            <path d={`M${frame.left} ${heightOf(score, frame)}H${frame.width - frame.right}`} />
            <text x={frame.left - 8} y={heightOf(score, frame) + 4}>
              {score}
            </text>
          </g>
        ))}
        <path class="curve-band" d={bandOf(found)} />
        <path class="curve-way" d={pathOf(found)} />
        {found.map(({ x, y, low, high, point }) => (
          <a key={point.id} href={`#/attempts/${point.id}`} aria-label={w("curvePoint", { score: point.score!.toFixed(0), day: day(point.created) })}>
            {found.length === 1 && <path class="curve-whisker" d={`M${x} ${low}V${high}`} />}
            <circle class="curve-hit" cx={x} cy={y} r="12" />
            <circle cx={x} cy={y} r="4.5" />
          </a>
        ))}
        {found.length > 0 && (
          <g class="curve-days">
            <text x={frame.left} y={frame.height - 8}>
              {when(found[0]!.point.created)}
            </text>
            {found.length > 1 && (
              <text class="end" x={frame.width - frame.right} y={frame.height - 8}>
                {when(found.at(-1)!.point.created)}
              </text>
            )}
          </g>
        )}
      </svg>
      <details>
        <summary>{w("asTable")}</summary>
        <table>
          <thead>
            <tr>
              <th scope="col">{w("when")}</th>
              <th scope="col" class="number">{w("mark")}</th>
              <th scope="col" class="number">{w("intervalShort")}</th>
            </tr>
          </thead>
          <tbody>
            {points.map((point) => (
              <tr key={point.id}>
                <th scope="row">
                  <a href={`#/attempts/${point.id}`}>{moment(point.created)}</a>
                </th>
                <td class="number">{point.score?.toFixed(0) ?? w("noMark")}</td>
                <td class="number">{point.interval ? point.interval.map((v) => v.toFixed(0)).join("–") : "–"}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </details>
    </figure>
  );
}

const locale = () => (language.value === "zh" ? "zh-Hant-TW" : "en-GB");
export const day = (time: string): string => new Date(time).toLocaleDateString(locale(), { month: "short", day: "numeric" });
const hour = (time: string): string => new Date(time).toLocaleTimeString(locale(), { hour: "2-digit", minute: "2-digit" });
export const moment = (time: string): string =>
  new Date(time).toLocaleString(locale(), { year: "numeric", month: "short", day: "numeric", hour: "2-digit", minute: "2-digit" });
