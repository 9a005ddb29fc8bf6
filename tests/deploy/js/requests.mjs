// HTTP as a client of a proxy speaks it: a connection of its own for each request, so that none hides behind another.
import { request as plainRequest } from 'node:http';
import { request as tlsRequest } from 'node:https';

export class Client {
  constructor(address, { token, ca, from = '127.0.0.1' }) {
    this.address = address;
    this.options = { ca, localAddress: from, agent: false, headers: { Authorization: `Bearer ${token}` } };
  }

  // Begins a request; whoever calls sends its body and ends it.
  begin(method, target, headers = {}) {
    const url = new URL(target, this.address);
    const start = url.protocol === 'https:' ? tlsRequest : plainRequest;
    return start(url, { ...this.options, method, headers: { ...this.options.headers, ...headers } });
  }

  // Resolves with { status, headers, body }.
  send(method, target, headers = {}, body = undefined) {
    const request = this.begin(method, target, headers);
    const answer = answerTo(request);
    request.end(body);
    return answer;
  }
}

export const answerTo = (request) =>
  new Promise((resolve, reject) => {
    request.on('error', reject);
    request.on('response', (response) => {
      const parts = [];
      response.on('error', reject);
      response.on('data', (part) => parts.push(part));
      response.on('end', () =>
        resolve({ status: response.statusCode, headers: response.headers, body: Buffer.concat(parts) }),
      );
    });
  });

export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Resolves with what `look` resolves with, once that is true.
export async function eventually(look, what, ms = 20000) {
  const end = Date.now() + ms;
  for (;;) {
    const found = await look();
    if (found) return found;
    if (Date.now() > end) throw new Error(`not within ${ms / 1000} s: ${what}`);
    await sleep(50);
  }
}
