import { send } from "../api/client";

// A link by which others look at one result. The answer to its creation alone has the secret.
export interface Share {
  id: string;
  name: string;
  created_at_ms: number;
  last_used_at_ms: number;
  expires_at_ms: number;
  withdrawn: boolean;
}

const address_of_shares = (job_id: string): string => `/api/v1/jobs/${encodeURIComponent(job_id)}/shares`;

export async function list_shares(job_id: string): Promise<Share[]> {
  const page = (await (await send(address_of_shares(job_id))).json()) as { items: Share[] };
  return page.items;
}

// Creates a link and returns its address; the secret stands behind the #, which browsers send to no server.
export async function create_share(job_id: string, name: string, expires_in_s: number): Promise<string> {
  const response = await send(address_of_shares(job_id), {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ name, expires_in_s }),
  });
  const { secret } = (await response.json()) as { secret: string };
  return `${window.location.origin}/share?job=${encodeURIComponent(job_id)}#${secret}`;
}

export async function withdraw_share(job_id: string, share_id: string): Promise<void> {
  await send(`${address_of_shares(job_id)}/${encodeURIComponent(share_id)}`, { method: "DELETE" });
}
