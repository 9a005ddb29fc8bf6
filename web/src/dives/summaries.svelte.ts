import { api } from "../api/client";
import type { Dive, FigurePoint, Job } from "../api/types";

// What the list shows of a dive beyond the dive itself: its newest reconstruction and how good that is.
export interface Summary {
  job: Job | undefined;
  path_bound_m: number | undefined;
  surface_bound_m: number | undefined;
}

export const kPathBound = "expected_accuracy.trajectory.ate.bound_m";
export const kSurfaceBound = "expected_accuracy.surface.error_95_m";
const kPage = 200;
const kAtOnce = 4;

async function newest_values(metric: string, dive_id?: string): Promise<Map<string, number>> {
  try {
    const page = await api.get("/api/v1/metrics", { query: { metric, dive_id, limit: kPage, kind: "reconstruct" } });
    return new Map(page.items.map((point: FigurePoint) => [point.job_id, point.value]));
  } catch {
    return new Map(); // The metric was never measured, or the token may not read it.
  }
}

// Loads the newest jobs of all dives with one request, and those of older dives one by one.
export class Summaries {
  by_dive = $state.raw(new Map<string, Summary>());
  #path = new Map<string, number>();
  #surface = new Map<string, number>();
  #waiting: Dive[] = [];
  #num_running = 0;

  async load(): Promise<void> {
    const [jobs, path, surface] = await Promise.all([
      api.get("/api/v1/jobs", { query: { kind: "reconstruct", order: "newest", limit: kPage } }),
      newest_values(kPathBound),
      newest_values(kSurfaceBound),
    ]);
    this.#path = path;
    this.#surface = surface;
    const found = new Map(this.by_dive);
    const seen = new Set<string>();
    for (const job of jobs.items) {
      if (seen.has(job.dive_id)) continue;
      seen.add(job.dive_id);
      found.set(job.dive_id, this.#summary(jobs.items.find((other) => other.dive_id === job.dive_id && other.state === "succeeded") ?? job));
    }
    this.by_dive = found;
  }

  // Asks for the dives that the first request did not reach.
  want(dives: Dive[]): void {
    this.#waiting = dives.filter(({ id, state }) => !this.by_dive.has(id) && state === "ready");
    this.#next();
  }

  #summary(job: Job | undefined): Summary {
    return {
      job,
      path_bound_m: job ? this.#path.get(job.id) : undefined,
      surface_bound_m: job ? this.#surface.get(job.id) : undefined,
    };
  }

  #next(): void {
    while (this.#num_running < kAtOnce && this.#waiting.length > 0) {
      const dive = this.#waiting.shift();
      if (dive) void this.#ask(dive);
    }
  }

  async #ask(dive: Dive): Promise<void> {
    this.#num_running += 1;
    try {
      const query = { dive_id: dive.id, kind: "reconstruct", order: "newest", limit: 20 } as const;
      const [jobs, path, surface] = await Promise.all([
        api.get("/api/v1/jobs", { query }),
        newest_values(kPathBound, dive.id),
        newest_values(kSurfaceBound, dive.id),
      ]);
      for (const [id, value] of path) this.#path.set(id, value);
      for (const [id, value] of surface) this.#surface.set(id, value);
      const job = jobs.items.find(({ state }) => state === "succeeded") ?? jobs.items[0];
      this.by_dive = new Map(this.by_dive).set(dive.id, this.#summary(job));
    } catch {
      // The row stays without a verdict; the next load asks again.
    }
    this.#num_running -= 1;
    this.#next();
  }
}
