import { artifact_address, send } from "../api/client";
import type { Artifact, Job } from "../api/types";
import type { Errors, Point } from "./measure";

// The small text files of a result, as far as the page draws them.
export interface Pose {
  time_s: number;
  position: Point;
}

export interface Keyframe {
  frame_index: number;
  orientation_wxyz: [number, number, number, number];
  position_m: Point;
  picture?: string;
  timestamp_ns: number;
}

export interface Keyframes {
  focal_px: number;
  image_size_px: [number, number];
  principal_point_px?: [number, number];
  keyframes: Keyframe[];
}

export function artifact_named(artifacts: Artifact[], name: string): Artifact | undefined {
  return artifacts.find((artifact) => artifact.name === name);
}

export function address_in(job: Job, artifact: Artifact): string {
  return artifact_address(job.id, artifact.name, artifact.sha256);
}

export async function text_of(job: Job, artifacts: Artifact[], name: string): Promise<string | undefined> {
  const artifact = artifact_named(artifacts, name);
  if (!artifact) return undefined;
  return (await send(address_in(job, artifact))).text();
}

export async function json_of<T>(job: Job, artifacts: Artifact[], name: string): Promise<T | undefined> {
  const text = await text_of(job, artifacts, name);
  return text === undefined ? undefined : (JSON.parse(text) as T);
}

// Returns the poses of a TUM file: timestamp_s x y z qx qy qz qw.
export function poses_of(tum: string): Pose[] {
  return tum
    .split("\n")
    .filter((line) => line !== "" && !line.startsWith("#"))
    .map((line) => line.trim().split(/\s+/).map(Number))
    .filter((row) => row.length >= 4 && row.every(Number.isFinite))
    .map(([time_s, x, y, z]) => ({ time_s: time_s as number, position: [x as number, y as number, z as number] as const }));
}

// metrics.json as deep as it is; what is absent was not measured.
export type Metrics = Record<string, unknown>;

export function metric_at(metrics: Metrics | undefined, path: string): unknown {
  return path
    .split(".")
    .reduce<unknown>((value, key) => (value && typeof value === "object" ? (value as Metrics)[key] : undefined), metrics);
}

export function number_at(metrics: Metrics | undefined, path: string): number | undefined {
  const value = metric_at(metrics, path);
  return typeof value === "number" && Number.isFinite(value) ? value : undefined;
}

// Returns the errors of a result: its median sigma for every point, until that of the place is known.
export function errors_of(metrics: Metrics | undefined): Errors {
  const median = number_at(metrics, "expected_accuracy.surface.sigma_median_m") ?? null;
  return {
    sigma_at: () => median,
    scale_sigma: number_at(metrics, "calibration.scale_sigma") ?? 0.0025,
  };
}
