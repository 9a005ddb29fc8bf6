// Whether the server answers. While it does not, it is asked every two seconds, and views that
// registered with when_back load again once it does.
const kAskEvery_ms = 2000;

class Connection {
  gone = $state(false);
  #listeners = new Set<() => void>();
  #timer: ReturnType<typeof setTimeout> | undefined;

  lost(): void {
    if (this.gone) return;
    this.gone = true;
    this.#ask_later();
  }

  answered(): void {
    if (!this.gone) return;
    this.gone = false;
    clearTimeout(this.#timer);
    for (const listener of [...this.#listeners]) listener();
  }

  // Calls the function each time the server is back; returns what ends that.
  when_back(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  #ask_later(): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => void this.#ask(), kAskEvery_ms);
  }

  async #ask(): Promise<void> {
    try {
      const response = await fetch("/healthz/live", { cache: "no-store" });
      if (response.ok) return this.answered();
    } catch {
      // Not yet.
    }
    this.#ask_later();
  }
}

export const connection = new Connection();
