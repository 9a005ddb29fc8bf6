// Measurements between points on the surface, in metres of the world frame, with half of their 95 %
// interval from the sigma of each point and the error of scale.
export type Point = readonly [number, number, number];
export type Tool = "length" | "polyline" | "area" | "angle";

export interface Errors {
  // Standard deviation of the surface at a point, m; null where the result states none.
  sigma_at: (point: Point) => number | null;
  // Relative standard deviation of all lengths.
  scale_sigma: number;
}

export interface Measured {
  value: number;
  half: number | null;
}

const kZ95 = 1.959964;

export const subtract = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const norm = (a: Point): number => Math.sqrt(dot(a, a));
export const distance = (a: Point, b: Point): number => norm(subtract(a, b));

export function path_length(points: readonly Point[]): number {
  return points.slice(1).reduce((sum, point, index) => sum + distance(points[index] as Point, point), 0);
}

// Returns the planar area of an outline by Newell's method: of its projection along its mean normal.
export function outline_area(points: readonly Point[]): number {
  let normal: Point = [0, 0, 0];
  points.forEach((a, index) => {
    const b = points[(index + 1) % points.length] as Point;
    normal = [normal[0] + a[1] * b[2] - a[2] * b[1], normal[1] + a[2] * b[0] - a[0] * b[2], normal[2] + a[0] * b[1] - a[1] * b[0]];
  });
  return norm(normal) / 2;
}

// Returns the angle at the second of three points, rad.
export function angle_at(points: readonly Point[]): number {
  const [a, b, c] = points as [Point, Point, Point];
  const u = subtract(a, b);
  const v = subtract(c, b);
  const cosine = dot(u, v) / (norm(u) * norm(v));
  return Math.acos(Math.min(1, Math.max(-1, cosine)));
}

const kFunctions: Record<Tool, { of: (points: readonly Point[]) => number; power: number; least: number; most: number }> = {
  length: { of: path_length, power: 1, least: 2, most: 2 },
  polyline: { of: path_length, power: 1, least: 2, most: Infinity },
  area: { of: outline_area, power: 2, least: 3, most: Infinity },
  angle: { of: angle_at, power: 0, least: 3, most: 3 },
};

export function least_points(tool: Tool): number {
  return kFunctions[tool].least;
}

export function most_points(tool: Tool): number {
  return kFunctions[tool].most;
}

// Returns what the tool measures; the errors of the points count as independent of each other.
export function measure(tool: Tool, points: readonly Point[], errors: Errors): Measured {
  const { of, power } = kFunctions[tool];
  const value = of(points);
  const sigmas = points.map(errors.sigma_at);
  if (sigmas.includes(null)) return { value, half: null };
  const from_points = variance_from(sigmas as number[], of, points);
  const from_scale = (power * errors.scale_sigma * value) ** 2;
  return { value, half: kZ95 * Math.sqrt(from_points + from_scale) };
}

// Returns the variance that the errors of the points cause, with derivatives by central differences.
function variance_from(sigmas: number[], of: (points: readonly Point[]) => number, points: readonly Point[]): number {
  const step = 1e-4;
  let sum = 0;
  points.forEach((point, index) => {
    for (const axis of [0, 1, 2]) {
      const moved = (by: number): Point[] =>
        points.map((other, place) => (place === index ? (point.map((x, a) => (a === axis ? x + by : x)) as unknown as Point) : other));
      sum += (((sigmas[index] as number) * (of(moved(step)) - of(moved(-step)))) / (2 * step)) ** 2;
    }
  });
  return sum;
}
