import { settings } from "../app/settings.svelte";
import { candidates_of, type Candidate } from "./candidates";
import type { Dropped } from "./dropped";
import { Upload } from "./upload.svelte";

const kKey = "divemesh.uploads";
const kAtOnce = 3;

interface Remembered {
  name: string;
  fingerprint: string;
  total_bytes: number;
  sent_bytes: number;
  preset: string;
}

// All uploads of this browser. Those that a reload or restart interrupted are remembered by name,
// and go on when the same files are dropped again.
class Uploads {
  items = $state<Upload[]>([]);
  offered = $state.raw<Candidate[]>();

  constructor() {
    for (const item of remembered()) {
      const upload = new Upload(undefined, item.name, item.fingerprint, item.total_bytes, item.preset, () => undefined);
      upload.sent_bytes = item.sent_bytes;
      this.items.push(upload);
    }
    window.addEventListener("beforeunload", (event) => {
      if (this.items.some(({ state }) => state === "sending")) event.preventDefault();
    });
  }

  // Offers what was dropped, to be looked at before it is sent.
  offer(dropped: Dropped[]): void {
    this.offered = candidates_of(dropped);
  }

  // Starts the uploads; those that were interrupted resume with their own preset.
  begin(candidates: Candidate[], preset: string): void {
    this.offered = undefined;
    for (const candidate of candidates) {
      const earlier = this.items.find((item) => item.fingerprint === candidate.fingerprint);
      if (earlier && ["reading", "sending", "waiting"].includes(earlier.state)) continue;
      this.items = this.items.filter((item) => item !== earlier);
      const chosen = earlier?.state === "interrupted" ? earlier.preset : preset;
      const size = candidate.blob.size;
      const upload: Upload = new Upload(candidate, candidate.name, candidate.fingerprint, size, chosen, () => this.changed());
      if (earlier) upload.sent_bytes = earlier.sent_bytes;
      this.items.push(upload);
    }
    settings.store();
    this.changed();
  }

  async remove(upload: Upload): Promise<void> {
    this.items = this.items.filter((item) => item !== upload);
    await upload.discard();
    this.changed();
  }

  changed(): void {
    remember(this.items);
    const num_sending = this.items.filter(({ state }) => state === "sending" || state === "reading").length;
    for (const next of this.items.filter(({ state }) => state === "waiting").slice(0, kAtOnce - num_sending)) void next.start();
  }
}

function remembered(): Remembered[] {
  try {
    return JSON.parse(localStorage.getItem(kKey) ?? "[]") as Remembered[];
  } catch {
    return [];
  }
}

function remember(items: Upload[]): void {
  const open = items.filter(({ state }) => state !== "complete" && state !== "failed");
  const list: Remembered[] = open.map(({ name, fingerprint, total_bytes, sent_bytes, preset }) => ({
    name,
    fingerprint,
    total_bytes,
    sent_bytes,
    preset,
  }));
  try {
    localStorage.setItem(kKey, JSON.stringify(list));
  } catch {
    // Without storage an upload does not survive a reload.
  }
}

export const uploads = new Uploads();
