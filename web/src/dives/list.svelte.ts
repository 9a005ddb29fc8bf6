import { api } from "../api/client";
import type { Dive } from "../api/types";
import type { Summary } from "./summaries.svelte";

export type Sort = "newest" | "oldest" | "name" | "site" | "length" | "verdict";
const kPage = 200;
const kRank: Record<string, number> = { not_usable: 0, usable_with_restrictions: 1, good: 2 };

// The dives of the project, page by page. A search or a sort that the server does not know needs
// all of them, so the remaining pages are then loaded.
export class DiveList {
  dives = $state.raw<Dive[]>([]);
  more = $state(false);
  loading = $state(false);
  loaded = $state(false);
  #cursor = "";
  #order: "newest" | "oldest" = "newest";
  #deleted = false;
  #generation = 0;

  async load(order: "newest" | "oldest", deleted: boolean): Promise<void> {
    this.#order = order;
    this.#deleted = deleted;
    this.#generation += 1;
    const first = await this.#page("", this.#generation);
    if (!first) return;
    this.dives = first;
    this.loaded = true;
  }

  async load_more(): Promise<void> {
    if (!this.more || this.loading) return;
    const next = await this.#page(this.#cursor, this.#generation);
    if (next) this.dives = [...this.dives, ...next];
  }

  async load_rest(): Promise<void> {
    while (this.more && !this.loading) await this.load_more();
  }

  async #page(cursor: string, generation: number): Promise<Dive[] | undefined> {
    this.loading = true;
    try {
      const query = { limit: kPage, cursor, order: this.#order, deleted: this.#deleted };
      const page = await api.get("/api/v1/dives", { query });
      if (generation !== this.#generation) return undefined;
      this.#cursor = page.next_cursor;
      this.more = page.next_cursor !== "";
      return page.items;
    } finally {
      this.loading = false;
    }
  }
}

export interface Filter {
  search: string;
  state: string;
  verdict: string;
  tag: string;
}

// Returns the dives that a filter lets through.
export function filtered(dives: Dive[], filter: Filter, summaries: Map<string, Summary>): Dive[] {
  const words = filter.search.toLowerCase().split(/\s+/).filter(Boolean);
  return dives.filter((dive) => {
    if (filter.state && dive.state !== filter.state) return false;
    if (filter.tag && !dive.tags.includes(filter.tag)) return false;
    if (filter.verdict && summaries.get(dive.id)?.job?.verdict !== filter.verdict) return false;
    if (words.length === 0) return true;
    const text = [dive.name, dive.site, dive.rig, dive.id, ...dive.tags].join("\n").toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

export function sorted(dives: Dive[], sort: Sort, summaries: Map<string, Summary>): Dive[] {
  const rank = (dive: Dive): number => kRank[summaries.get(dive.id)?.job?.verdict ?? ""] ?? 3;
  const compare: Record<Sort, (a: Dive, b: Dive) => number> = {
    newest: (a, b) => b.created_at_ms - a.created_at_ms,
    oldest: (a, b) => a.created_at_ms - b.created_at_ms,
    name: (a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }),
    site: (a, b) => a.site.localeCompare(b.site) || b.created_at_ms - a.created_at_ms,
    length: (a, b) => b.duration_s - a.duration_s,
    verdict: (a, b) => rank(a) - rank(b) || b.created_at_ms - a.created_at_ms,
  };
  return [...dives].sort(compare[sort]);
}
