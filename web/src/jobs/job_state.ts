import type { Job, JobState } from "../api/types";

const kEnded: JobState[] = ["succeeded", "failed", "dead", "cancelled"];

export function has_ended(job: Job): boolean {
  return kEnded.includes(job.state);
}

export function can_be_cancelled(job: Job): boolean {
  return !has_ended(job) && !job.cancel_requested;
}

export function can_be_retried(job: Job): boolean {
  return job.state === "failed" || job.state === "dead" || job.state === "cancelled";
}

const kStages: Record<string, string[]> = {
  intake: ["check"],
  reconstruct: ["track", "optimise", "fuse", "mesh", "texture", "evaluate", "publish"],
};

export interface StageRow {
  name: string;
  state: "done" | "running" | "waiting";
  seconds: number;
  from_cache: boolean;
}

// Returns the stages of a job in their order: those that are done, the one that runs, those to come.
export function stage_rows(job: Job): StageRow[] {
  const done = new Map(job.stages.map((stage) => [stage.name, stage]));
  const current = job.state === "running" ? job.progress.stage : "";
  const order = [...(kStages[job.kind] ?? [])];
  for (const name of [...done.keys(), current]) {
    if (name && !order.includes(name)) order.push(name);
  }
  const last = Math.max(-1, ...order.map((name, index) => (done.has(name) || name === current ? index : -1)));
  return order
    .map((name, index): StageRow & { index: number } => {
      const run = done.get(name);
      const state = run ? "done" : name === current ? "running" : "waiting";
      return { name, state, seconds: run?.seconds ?? 0, from_cache: run?.from_cache ?? false, index };
    })
    .filter((row) => row.state !== "waiting" || (row.index > last && !has_ended(job)));
}
