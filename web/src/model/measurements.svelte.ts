import { least_points, measure, most_points, type Errors, type Measured, type Point, type Tool } from "./measure";

export interface Measurement extends Measured {
  id: number;
  tool: Tool;
  points: Point[];
  height_m: number;
  perimeter_m: number;
}

// The measurements in one model: those that are done, and the one that is being made.
export class Measurements {
  tool = $state<Tool | "orbit">("orbit");
  pending = $state.raw<Point[]>([]);
  done = $state.raw<Measurement[]>([]);
  errors = $state.raw<Errors>({ sigma_at: () => null, scale_sigma: 0 });
  #next_id = 1;

  // Takes better known errors, also for what was measured before.
  set_errors(errors: Errors): void {
    this.errors = errors;
    this.done = this.done.map((item) => ({ ...item, ...measure(item.tool, item.points, errors) }));
  }

  choose(tool: Tool | "orbit"): void {
    this.tool = tool;
    this.pending = [];
  }

  add_point(point: Point): void {
    if (this.tool === "orbit") return;
    this.pending = [...this.pending, point];
    if (this.pending.length === most_points(this.tool)) this.finish();
  }

  get can_finish(): boolean {
    return this.tool !== "orbit" && this.pending.length >= least_points(this.tool);
  }

  finish(): void {
    if (this.tool === "orbit" || !this.can_finish) return;
    const points = this.pending;
    const heights = points.map(([, , z]) => z);
    const around = measure("polyline", [...points, points[0] as Point], this.errors).value;
    this.done = [
      ...this.done,
      {
        ...measure(this.tool, points, this.errors),
        id: this.#next_id,
        tool: this.tool,
        points,
        height_m: Math.max(...heights) - Math.min(...heights),
        perimeter_m: around,
      },
    ];
    this.#next_id += 1;
    this.pending = [];
  }

  undo(): void {
    this.pending = this.pending.slice(0, -1);
  }

  remove(id: number): void {
    this.done = this.done.filter((item) => item.id !== id);
  }

  clear(): void {
    this.done = [];
    this.pending = [];
  }

  // Returns what is drawn: all points and lines.
  shapes(): { points: Point[]; closed: boolean }[] {
    const finished = this.done.map(({ tool, points }) => ({ points, closed: tool === "area" }));
    return this.pending.length > 0 ? [...finished, { points: this.pending, closed: false }] : finished;
  }
}

// Returns the place of a measurement's label.
export function middle_of(points: readonly Point[]): Point {
  const sum = points.reduce<Point>((a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]], [0, 0, 0]);
  return [sum[0] / points.length, sum[1] / points.length, sum[2] / points.length];
}
