import { connection } from "./connection.svelte";
import { problem_of, server_gone } from "./problem";
import type { paths } from "./schema";
import { session } from "./session.svelte";

type Method = "get" | "post" | "patch" | "delete";
type PathWith<M extends Method> = {
  [P in keyof paths]: paths[P] extends Record<M, object> ? P : never;
}[keyof paths];
type Operation<P extends keyof paths, M extends Method> = M extends keyof paths[P] ? paths[P][M] : never;
type Content<R> = R extends { content: { "application/json": infer B } } ? B : undefined;
type Ok<R> = R extends { 200: infer A } ? Content<A> : R extends { 201: infer A } ? Content<A> : undefined;
export type Answer<P extends keyof paths, M extends Method> = Operation<P, M> extends { responses: infer R } ? Ok<R> : never;
type Body<P extends keyof paths, M extends Method> = Operation<P, M> extends {
  requestBody?: { content: { "application/json": infer B } };
}
  ? B
  : undefined;
type Query<P extends keyof paths, M extends Method> = Operation<P, M> extends { parameters: { query?: infer Q } } ? Q : never;

export interface Asked<Q, B> {
  path?: Record<string, string | number>;
  query?: Q;
  body?: B;
  headers?: Record<string, string>;
  signal?: AbortSignal;
}

// Returns the address of a path of the API with its parameters and query filled in.
export function address_of(path: string, parameters: Record<string, string | number> = {}, query: object = {}): string {
  const filled = path.replace(/\{(\w+)\}/g, (_, name: string) =>
    String(parameters[name]).split("/").map(encodeURIComponent).join("/"),
  );
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    if (value !== undefined && value !== "") search.set(name, String(value));
  }
  const text = search.toString();
  return text ? `${filled}?${text}` : filled;
}

// Sends one request with the session's cookie; throws a Problem for every answer that is no success.
export async function send(address: string, init: RequestInit = {}): Promise<Response> {
  const headers = new Headers(init.headers);
  if (init.method && init.method !== "GET") headers.set("X-CSRF-Token", session.csrf_token);
  if (session.bearer) headers.set("Authorization", `Bearer ${session.bearer}`);
  let response: Response;
  try {
    response = await fetch(address, { credentials: "same-origin", ...init, headers });
  } catch (thrown) {
    if (init.signal?.aborted) throw thrown;
    connection.lost();
    throw server_gone();
  }
  connection.answered();
  if (response.ok) return response;
  const problem = await problem_of(response);
  if (problem.status === 401 && !address.startsWith("/api/v1/session")) session.ended();
  throw problem;
}

async function ask(method: Method, path: string, asked: Asked<object, unknown>): Promise<unknown> {
  const headers = new Headers(asked.headers);
  headers.set("Accept", "application/json");
  if (asked.body !== undefined) headers.set("Content-Type", "application/json");
  const response = await send(address_of(path, asked.path, asked.query), {
    method: method.toUpperCase(),
    headers,
    body: asked.body === undefined ? undefined : JSON.stringify(asked.body),
    signal: asked.signal,
  });
  const is_json = (response.headers.get("Content-Type") ?? "").includes("json");
  return is_json ? response.json() : undefined;
}

// The typed client: paths, queries, bodies and answers are those of openapi.yaml.
export const api = {
  get<P extends PathWith<"get">>(path: P, asked: Asked<Query<P, "get">, never> = {}) {
    return ask("get", path, asked as Asked<object, unknown>) as Promise<Answer<P, "get">>;
  },
  post<P extends PathWith<"post">>(path: P, asked: Asked<Query<P, "post">, Body<P, "post">> = {}) {
    return ask("post", path, asked as Asked<object, unknown>) as Promise<Answer<P, "post">>;
  },
  patch<P extends PathWith<"patch">>(path: P, asked: Asked<Query<P, "patch">, Body<P, "patch">> = {}) {
    return ask("patch", path, asked as Asked<object, unknown>) as Promise<Answer<P, "patch">>;
  },
  delete<P extends PathWith<"delete">>(path: P, asked: Asked<Query<P, "delete">, never> = {}) {
    return ask("delete", path, asked as Asked<object, unknown>) as Promise<Answer<P, "delete">>;
  },
};

// Returns the address of an artifact. With its hash it names exactly these bytes and stays in the browser's cache.
export function artifact_address(job_id: string, name: string, sha256?: string): string {
  return address_of("/api/v1/jobs/{job_id}/artifacts/{artifact_name}", { job_id, artifact_name: name }, { sha256 });
}
