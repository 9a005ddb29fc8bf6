import type { DetailedError, HttpResponse, Upload as TusUpload } from "tus-js-client";
import { api } from "../api/client";
import { connection } from "../api/connection.svelte";
import { as_problem, Problem } from "../api/problem";
import { session } from "../api/session.svelte";
import type { Preset } from "../api/types";
import type { Candidate } from "./candidates";
import { identity_of } from "./identity";

export type UploadState = "waiting" | "reading" | "sending" | "paused" | "interrupted" | "failed" | "complete";

const kChunk_bytes = 32 * 1024 * 1024;
const kLongestWait_s = 60;
const kRateWindow_ms = 8000;

// One upload: sends with tus, tries again while the link is down, and states rate and time left.
export class Upload {
  state = $state<UploadState>("waiting");
  sent_bytes = $state(0);
  rate_bytes_per_s = $state(0);
  retry_in_s = $state(0);
  problem = $state<Problem>();
  dive_id = $state("");
  // The server had the recording before: nothing was sent.
  was_there = $state(false);
  #tus: TusUpload | undefined;
  #samples: { at: number; bytes: number }[] = [];
  #wait_s = 1;
  #countdown: ReturnType<typeof setInterval> | undefined;

  constructor(
    readonly candidate: Candidate | undefined,
    readonly name: string,
    readonly fingerprint: string,
    readonly total_bytes: number,
    readonly preset: string,
    readonly on_change: () => void,
  ) {
    if (!candidate) this.state = "interrupted";
  }

  get fraction(): number {
    return this.total_bytes > 0 ? this.sent_bytes / this.total_bytes : 0;
  }

  get seconds_left(): number | undefined {
    if (this.state !== "sending" || !(this.rate_bytes_per_s > 0)) return undefined;
    return (this.total_bytes - this.sent_bytes) / this.rate_bytes_per_s;
  }

  async start(): Promise<void> {
    if (!this.candidate) return;
    this.problem = undefined;
    this.#set("reading");
    try {
      const tus = (this.#tus ??= await this.#make(this.candidate));
      const earlier = await tus.findPreviousUploads();
      if (!earlier[0] && !tus.url && (await this.#find_dive(this.candidate, tus))) return;
      if (this.state !== "reading") return;
      this.#set("sending");
      if (earlier[0] && !tus.url) tus.resumeFromPreviousUpload(earlier[0]);
      tus.start();
    } catch (thrown) {
      const problem = as_problem(thrown);
      if (!problem.is_gone) return this.#fail(problem);
      this.#set("sending");
      this.#try_later();
    }
  }

  async pause(): Promise<void> {
    this.#end_countdown();
    this.#set("paused");
    await this.#tus?.abort();
  }

  // Ends the upload and frees its bytes at the server.
  async discard(): Promise<void> {
    this.#end_countdown();
    if (this.state !== "complete") await this.#tus?.abort(true).catch(() => undefined);
  }

  // Asks whether the server has the recording already, and otherwise states its identity with the upload.
  async #find_dive(candidate: Candidate, tus: TusUpload): Promise<boolean> {
    const content_sha256 = await identity_of(candidate.files);
    if (!content_sha256) return false;
    tus.options.metadata = { ...tus.options.metadata, dive: content_sha256 };
    if (!session.can("dives:read")) return false;
    const page = await api.get("/api/v1/dives", { query: { content_sha256 } });
    const dive = page.items.find(({ state }) => state !== "refused");
    if (!dive || this.state !== "reading") return false;
    if (this.preset) {
      const body = { kind: "reconstruct" as const, preset: this.preset as Preset, priority: 0 };
      await api.post("/api/v1/dives/{dive_id}/jobs", { path: { dive_id: dive.id }, body });
    }
    this.was_there = true;
    this.dive_id = dive.id;
    this.sent_bytes = this.total_bytes;
    this.#set("complete");
    return true;
  }

  async #make(candidate: Candidate): Promise<TusUpload> {
    const tus = await import("tus-js-client");
    const metadata: Record<string, string> = { filename: candidate.filename };
    if (this.preset) metadata.job = this.preset;
    else metadata.commit = "1";
    return new tus.Upload(candidate.blob, {
      endpoint: "/api/v1/uploads",
      metadata,
      chunkSize: kChunk_bytes,
      retryDelays: null,
      removeFingerprintOnSuccess: true,
      fingerprint: () => Promise.resolve(`divemesh:${this.fingerprint}`),
      onBeforeRequest: (request) => request.setHeader("X-CSRF-Token", session.csrf_token),
      onProgress: (sent) => this.#progressed(sent),
      onSuccess: (payload) => this.#succeeded(payload.lastResponse),
      onError: (error) => this.#failed(error as DetailedError),
    });
  }

  #progressed(sent: number): void {
    this.#wait_s = 1;
    connection.answered();
    const now = performance.now();
    this.sent_bytes = sent;
    this.#samples = [...this.#samples.filter(({ at }) => now - at < kRateWindow_ms), { at: now, bytes: sent }];
    const first = this.#samples[0];
    if (first && now - first.at > 500) this.rate_bytes_per_s = (1000 * (sent - first.bytes)) / (now - first.at);
    this.on_change();
  }

  #succeeded(response: HttpResponse): void {
    this.sent_bytes = this.total_bytes;
    this.dive_id = response.getHeader("Divemesh-Dive") ?? "";
    this.#set("complete");
  }

  // A link that is down is waited for; what the server refuses is shown.
  #failed(error: DetailedError): void {
    if (this.state !== "sending") return;
    const response = error.originalResponse;
    const status = response?.getStatus() ?? 0;
    if (status === 0 || status === 409 || status === 423 || status === 429 || status >= 502) return this.#try_later();
    this.#fail(problem_in(response, status));
  }

  #fail(problem: Problem): void {
    this.problem = problem;
    if (problem.status === 401) session.ended();
    this.#set("failed");
  }

  #try_later(): void {
    this.retry_in_s = this.#wait_s;
    this.#wait_s = Math.min(2 * this.#wait_s, kLongestWait_s);
    this.#samples = [];
    this.rate_bytes_per_s = 0;
    this.#end_countdown();
    this.#countdown = setInterval(() => {
      this.retry_in_s -= 1;
      if (this.retry_in_s > 0) return;
      this.#end_countdown();
      if (this.state === "sending") void this.start();
    }, 1000);
  }

  #end_countdown(): void {
    clearInterval(this.#countdown);
    this.#countdown = undefined;
    if (this.state !== "sending") this.retry_in_s = 0;
  }

  #set(state: UploadState): void {
    this.state = state;
    this.on_change();
  }
}

function problem_in(response: HttpResponse | null | undefined, status: number): Problem {
  try {
    const body = JSON.parse(response?.getBody() ?? "") as { title: string; detail: string; request_id: string };
    return new Problem(status, body.title, body.detail, body.request_id);
  } catch {
    return new Problem(status, "", `HTTP ${status}`, response?.getHeader("X-Request-Id") ?? "");
  }
}
