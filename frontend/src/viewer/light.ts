// Where a lamp stands that is held over a point of a picture.

import { MOST_SLANT } from "./state";

/** The lamp over (x, y): the middle is straight above, the edge of the largest circle is along the sheet. Degrees. */
export function lightAt(x: number, y: number, size: { width: number; height: number }): { tilt: number; slant: number } {
  const radius = Math.min(size.width, size.height) / 2;
  const [right, up] = [(x - size.width / 2) / radius, (size.height / 2 - y) / radius];
  const away = Math.min(Math.hypot(right, up), 1);
  return {
    tilt: ((Math.atan2(up, right) * 180) / Math.PI + 360) % 360,
    slant: Math.min((Math.asin(away) * 180) / Math.PI, MOST_SLANT),
  };
}
