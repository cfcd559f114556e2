// The colours of distance: quiet on the line, loud far off. Lightness falls all along, so that the order survives
// colour blindness and a grey print; they are those of the printed report.

type Rgb = readonly [number, number, number];

export const STOPS: readonly Rgb[] = [[168, 188, 196], [226, 196, 122], [222, 128, 56], [176, 34, 26]];
export const UNCOVERED = "rgb(36 84 164)";
/** Distance from which a point of the master counts as left uncovered: 0.12 rms radii of the 0.3 that are r = 1. */
export const UNCOVERED_FROM = 0.4;

export function colourOf(r: number): Rgb {
  const at = Math.min(1, Math.max(0, r)) * (STOPS.length - 1);
  const k = Math.min(STOPS.length - 2, Math.floor(at));
  const mix = (i: 0 | 1 | 2) => Math.round(STOPS[k]![i] + (STOPS[k + 1]![i] - STOPS[k]![i]) * (at - k));
  return [mix(0), mix(1), mix(2)];
}

export const css = ([r, g, b]: Rgb): string => `rgb(${r} ${g} ${b})`;
