import { Problem, problem_of, server_gone } from "./problem";
import type { Scope } from "./types";

interface SessionBody {
  csrf_token: string;
  name: string;
  scopes: Scope[];
  project: string;
  shared_job?: string;
}

const kAddress = "/api/v1/session";

// Who is signed in. The token itself is not kept: the server exchanges it for a cookie that scripts
// cannot read, and for a CSRF token that lives in memory.
class Session {
  state = $state<"unknown" | "out" | "in">("unknown");
  name = $state("");
  project = $state("");
  scopes = $state<Scope[]>([]);
  csrf_token = $state("");
  // The job whose result a share link opens; empty for other tokens.
  shared_job = $state("");
  // The secret of an embedded viewer, which gets no cookie in a frame of another site. In memory alone.
  bearer = "";
  expired = $state(false);

  // Asks the server whether the cookie still counts.
  async resume(): Promise<void> {
    const response = await fetch(kAddress, { credentials: "same-origin" }).catch(() => {
      throw server_gone();
    });
    if (response.ok) this.#began((await response.json()) as SessionBody);
    else if (response.status === 401 || response.status === 404) this.state = "out";
    else throw await problem_of(response);
  }

  // Exchanges a token, the secret of a share link or a one-shot token for a session.
  async begin(secret: string): Promise<void> {
    const response = await fetch(kAddress, {
      method: "POST",
      credentials: "same-origin",
      headers: { Authorization: `Bearer ${secret}` },
    }).catch(() => {
      throw server_gone();
    });
    if (!response.ok) throw await problem_of(response);
    this.#began((await response.json()) as SessionBody);
  }

  // Takes a secret for this visit alone, without a cookie.
  embed(secret: string): void {
    this.bearer = secret;
    this.state = "in";
  }

  async end(): Promise<void> {
    const response = await fetch(kAddress, {
      method: "DELETE",
      credentials: "same-origin",
      headers: { "X-CSRF-Token": this.csrf_token },
    }).catch(() => {
      throw server_gone();
    });
    if (!response.ok && response.status !== 401) throw await problem_of(response);
    this.#out();
  }

  // The server no longer knows the session.
  ended(): void {
    if (this.state !== "in") return;
    this.#out();
    this.expired = true;
  }

  can(scope: Scope): boolean {
    return this.scopes.includes("admin") || this.scopes.includes(scope);
  }

  #began(body: SessionBody): void {
    this.name = body.name;
    this.project = body.project;
    this.scopes = body.scopes;
    this.csrf_token = body.csrf_token;
    this.shared_job = body.shared_job ?? "";
    this.expired = false;
    this.state = "in";
  }

  #out(): void {
    this.name = "";
    this.project = "";
    this.scopes = [];
    this.csrf_token = "";
    this.state = "out";
  }
}

export const session = new Session();

export function is_refused_secret(problem: Problem): boolean {
  return problem.status === 401 || problem.status === 403;
}
