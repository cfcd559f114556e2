// Where the lamp of the home page stands: it circles once by itself, unless somebody moves it.

export type Lamp = { tilt: number; slant: number };

const TURN_SECONDS = 14;
const CIRCLING_SLANT = 58;
/** Degrees: a lamp straight above shows no relief, one along the sheet hardly any light. */
const [HIGHEST, LOWEST] = [18, 74];
/** Degrees of a phone's tilt that bring the lamp from its highest place to its lowest. */
const TILT_RANGE = 35;
/** How a phone is held by a reader, degrees from lying flat. */
const READING_ANGLE = 35;

/** The lamp of a page that nobody touches; seconds since it was opened. */
export const circling = (seconds: number): Lamp => ({
  tilt: (((135 - (seconds / TURN_SECONDS) * 360) % 360) + 360) % 360,
  slant: CIRCLING_SLANT,
});

/** Whether the lamp has been all around: then it rests, since drawing on and on empties a battery. */
export const hasCircled = (seconds: number): boolean => seconds >= TURN_SECONDS;

/** The lamp of a pointer at (x, y) in a picture of this size, origin top left. */
export function pointed(x: number, y: number, size: { width: number; height: number }): Lamp {
  return aside((2 * x) / size.width - 1, 1 - (2 * y) / size.height);
}

/** The lamp of a phone that is tilted: beta to the front, gamma to the right, in degrees, as DeviceOrientationEvent has them. */
export function tilted(beta: number, gamma: number): Lamp {
  return aside(gamma / TILT_RANGE, (READING_ANGLE - beta) / TILT_RANGE);
}

/** A lamp to the right and up, each -1 to 1; the farther from the middle, the lower it stands. */
function aside(right: number, up: number): Lamp {
  const away = Math.min(Math.hypot(right, up), 1);
  return {
    tilt: ((Math.atan2(up, right) * 180) / Math.PI + 360) % 360,
    slant: HIGHEST + away * (LOWEST - HIGHEST),
  };
}
