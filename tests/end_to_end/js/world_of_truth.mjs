// What is known of a simulated dive, in the world of its reconstruction.
import { readFileSync } from "node:fs";
import { join } from "node:path";

const multiply = ([a, b, c, d], [e, f, g, h]) => [
  a * e - b * f - c * g - d * h,
  a * f + b * e + c * h - d * g,
  a * g - b * h + c * e + d * f,
  a * h + b * g - c * f + d * e,
];
const conjugate = ([w, x, y, z]) => [w, -x, -y, -z];
const rotate = (q, p) => multiply(multiply(q, [0, ...p]), conjugate(q)).slice(1);
export const add = (a, b) => a.map((value, axis) => value + b[axis]);
export const scale = (a, factor) => a.map((value) => value * factor);
export const subtract = (a, b) => add(a, scale(b, -1));

// Returns the map from the truth's world to that of the trajectory (TUM): by the pose in the middle of the dive,
// which both state.
export function world_of_truth(dive_folder, tum) {
  const poses = tum.split("\n").filter((line) => line && !line.startsWith("#"));
  const [time, ...pose] = poses[Math.floor(poses.length / 2)].split(" ");
  const time_ns = BigInt(time.replace(".", ""));
  const estimate = { position: pose.slice(0, 3).map(Number), rotation: [3, 0, 1, 2].map((at) => Number(pose[3 + at])) };
  const rows = readFileSync(join(dive_folder, "mav0/state_groundtruth_estimate0/data.csv"), "utf8").split("\n").slice(1).filter(Boolean);
  const apart = (row) => Number(BigInt(row.split(",")[0]) - time_ns);
  const nearest = rows.reduce((best, row) => (Math.abs(apart(row)) < Math.abs(apart(best)) ? row : best)).split(",").map(Number);
  const truth = { position: nearest.slice(1, 4), rotation: nearest.slice(4, 8) };
  const turn = multiply(estimate.rotation, conjugate(truth.rotation));
  return (p) => add(rotate(turn, subtract(p, truth.position)), estimate.position);
}

// Returns the place of a point on a canvas for the page's camera: z up, 50 degrees from top to bottom.
export function place_on(canvas, eye, target, point) {
  const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
  const dot = (a, b) => a.reduce((sum, value, axis) => sum + value * b[axis], 0);
  const unit = (a) => scale(a, 1 / Math.sqrt(dot(a, a)));
  const forward = unit(subtract(target, eye));
  const right = unit(cross(forward, [0, 0, 1]));
  const up = cross(right, forward);
  const p = subtract(point, eye);
  const focal_px = canvas.height / 2 / Math.tan((25 * Math.PI) / 180);
  return {
    x: canvas.width / 2 + (focal_px * dot(p, right)) / dot(p, forward),
    y: canvas.height / 2 - (focal_px * dot(p, up)) / dot(p, forward),
  };
}
