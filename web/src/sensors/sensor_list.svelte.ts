import { api } from "../api/client";
import type { Sensor } from "../api/types";

const kAsk_ms = 2000;
const kTick_ms = 1000;

// The sensors with their ages by the server's clock. When the server no longer answers, the ages go
// on growing, so that a card never looks live when it is not.
export class SensorList {
  sensors = $state.raw<Sensor[]>([]);
  loaded = $state(false);
  problem = $state.raw<unknown>();
  // The server's time now, Unix milliseconds.
  now_ms = $state(Date.now());
  #offset_ms = 0;
  #timers: ReturnType<typeof setInterval>[] = [];
  #asking = false;

  start(): void {
    void this.load();
    this.#timers = [setInterval(() => void this.load(), kAsk_ms), setInterval(() => this.#tick(), kTick_ms)];
  }

  stop(): void {
    for (const timer of this.#timers) clearInterval(timer);
  }

  async load(): Promise<void> {
    if (this.#asking || document.hidden) return;
    this.#asking = true;
    try {
      const page = await api.get("/api/v1/sensors", { query: { limit: 200 } });
      const heard = page.items.find((sensor) => sensor.status_at_ms > 0);
      if (heard) this.#offset_ms = heard.status_at_ms + heard.status_age_ms - Date.now();
      this.sensors = page.items;
      this.loaded = true;
      this.problem = undefined;
    } catch (thrown) {
      this.problem = thrown;
    }
    this.#asking = false;
    this.#tick();
  }

  #tick(): void {
    this.now_ms = Date.now() + this.#offset_ms;
  }
}
