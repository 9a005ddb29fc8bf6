import { texts } from "../texts/en";

interface Fault {
  detail: string;
  pointer?: string;
  parameter?: string;
}

interface ProblemBody {
  title: string;
  status: number;
  detail: string;
  request_id: string;
  errors?: Fault[];
}

// An answer that is an error: what is wrong, what to do, and the id under which the server logged it.
export class Problem extends Error {
  constructor(
    readonly status: number,
    readonly title: string,
    detail: string,
    readonly request_id: string,
    readonly faults: Fault[] = [],
  ) {
    super(detail);
    this.name = "Problem";
  }

  // Returns what to do next beyond what the server said; empty where its own words are enough.
  get remedy(): string {
    if (this.status === 0) return texts.problem.remedy_gone;
    if (this.status === 401) return texts.problem.remedy_unauthorized;
    if (this.status === 403) return texts.problem.remedy_forbidden;
    if (this.status === 404) return texts.problem.remedy_not_found;
    if (this.status === 429) return texts.problem.remedy_too_many;
    if (this.status >= 500 && this.status !== 507) return texts.problem.remedy_server;
    return "";
  }

  get is_gone(): boolean {
    return this.status === 0;
  }
}

// Returns the problem that a response states; one with the status alone where its body is no problem.
export async function problem_of(response: Response): Promise<Problem> {
  const request_id = response.headers.get("X-Request-Id") ?? "";
  try {
    const body = (await response.json()) as Partial<ProblemBody>;
    if (typeof body.detail === "string") {
      const title = body.title ?? response.statusText;
      return new Problem(response.status, title, body.detail, body.request_id ?? request_id, body.errors ?? []);
    }
  } catch {
    // The body is not JSON: a proxy may have answered.
  }
  return new Problem(response.status, response.statusText, texts.problem.status(response.status), request_id);
}

export function server_gone(): Problem {
  return new Problem(0, texts.problem.gone_title, texts.problem.gone, "");
}

// Returns any thrown value as a problem that can be shown.
export function as_problem(thrown: unknown): Problem {
  if (thrown instanceof Problem) return thrown;
  const words = thrown instanceof Error ? thrown.message : String(thrown);
  return new Problem(-1, texts.problem.page_title, words, "");
}
