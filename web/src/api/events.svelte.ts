import type { ServerEvent } from "./types";

type Listener = (event: ServerEvent) => void;

const kFirstDelay_ms = 1000;
const kLargestDelay_ms = 15000;

// Follows the server's events over one WebSocket, and resumes after the last one seen.
class Events {
  live = $state(false);
  #socket: WebSocket | undefined;
  #listeners = new Set<Listener>();
  #sequence = 0;
  #delay_ms = kFirstDelay_ms;
  #timer: ReturnType<typeof setTimeout> | undefined;

  // Calls the function for each event; returns what ends that. The socket is open while anybody listens.
  follow(listener: Listener): () => void {
    this.#listeners.add(listener);
    if (!this.#socket) this.#open();
    return () => {
      this.#listeners.delete(listener);
      if (this.#listeners.size === 0) this.#close();
    };
  }

  #open(): void {
    const address = new URL("/api/v1/events", window.location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    if (this.#sequence > 0) address.searchParams.set("since", String(this.#sequence));
    const socket = new WebSocket(address);
    this.#socket = socket;
    socket.onopen = () => {
      this.live = true;
      this.#delay_ms = kFirstDelay_ms;
    };
    socket.onmessage = (message) => this.#receive(String(message.data));
    socket.onclose = () => this.#closed(socket);
  }

  #receive(text: string): void {
    const event = JSON.parse(text) as ServerEvent;
    if (typeof event.sequence === "number") this.#sequence = event.sequence;
    for (const listener of [...this.#listeners]) listener(event);
  }

  #closed(socket: WebSocket): void {
    if (socket !== this.#socket) return;
    const was_refused = !this.live;
    this.live = false;
    this.#socket = undefined;
    if (this.#listeners.size === 0) return;
    if (was_refused) this.#sequence = 0; // The server may have removed the events since.
    this.#timer = setTimeout(() => this.#open(), this.#delay_ms);
    this.#delay_ms = Math.min(2 * this.#delay_ms, kLargestDelay_ms);
  }

  #close(): void {
    clearTimeout(this.#timer);
    const socket = this.#socket;
    this.#socket = undefined;
    this.live = false;
    socket?.close();
  }
}

export const events = new Events();
