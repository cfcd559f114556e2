// Affine maps between the copy "as written" and "aligned", interpolated in rotation, size and shift.

/** x' = a x + c y + e, y' = b x + d y + f, in the order of a canvas's setTransform. */
export type Matrix = readonly [a: number, b: number, c: number, d: number, e: number, f: number];
type Point = readonly [x: number, y: number];

export const IDENTITY: Matrix = [1, 0, 0, 1, 0, 0];

/** The map that applies `inner`, then `outer`. */
export const compose = (outer: Matrix, inner: Matrix): Matrix => {
  const [a, b, c, d, e, f] = outer;
  const [p, q, r, s, t, u] = inner;
  return [a * p + c * q, b * p + d * q, a * r + c * s, b * r + d * s, a * t + c * u + e, b * t + d * u + f];
};

export const transformPoint = ([a, b, c, d, e, f]: Matrix, [x, y]: Point): Point => [a * x + c * y + e, b * x + d * y + f];

/** Rotation (radians, clockwise on screen), size, and the rest: a symmetric stretch of determinant 1. */
export function decompose([a, b, c, d]: Matrix): { turn: number; size: number; stretch: readonly [number, number, number] } {
  const turn = Math.atan2(b - c, a + d);
  const size = Math.sqrt(Math.max(a * d - b * c, 1e-12));
  const [cos, sin] = [Math.cos(turn) / size, Math.sin(turn) / size];
  return { turn, size, stretch: [cos * a + sin * b, cos * c + sin * d, -sin * c + cos * d] };
}

/** The map at `share`, from 0 (identity) to 1 (`whole`), rotating and growing about `pivot`: the middle of the writing. */
export function interpolate(whole: Matrix, share: number, pivot: Point): Matrix {
  const { turn, size, stretch } = decompose(whole);
  const [cos, sin] = [Math.cos(turn * share), Math.sin(turn * share)].map((v) => v * Math.pow(size, share)) as [number, number];
  const [xx, xy, yy] = [1 + share * (stretch[0] - 1), share * stretch[1], 1 + share * (stretch[2] - 1)];
  const linear = compose([cos, sin, -sin, cos, 0, 0], [xx, xy, xy, yy, 0, 0]);
  const goal = transformPoint(whole, pivot);
  const there = [pivot[0] + share * (goal[0] - pivot[0]), pivot[1] + share * (goal[1] - pivot[1])] as const;
  const here = transformPoint(linear, pivot);
  return [linear[0], linear[1], linear[2], linear[3], there[0] - here[0], there[1] - here[1]];
}

/** Maps fractions of a picture into the unit square, whole and centred. */
export function fitInSquare(width: number, height: number): Matrix {
  const longer = Math.max(width, height, 1);
  const [w, h] = [width / longer, height / longer];
  return [w, 0, 0, h, (1 - w) / 2, (1 - h) / 2];
}

export const centroid = (points: readonly (readonly number[])[]): Point => {
  if (!points.length) return [0.5, 0.5];
  const sum = points.reduce(([x, y], p) => [x! + p[0]!, y! + p[1]!], [0, 0]);
  return [sum[0]! / points.length, sum[1]! / points.length];
};
