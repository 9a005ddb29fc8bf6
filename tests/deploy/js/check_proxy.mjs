// node check_proxy.mjs nginx|caddy SOURCE PROGRAM: the example of that proxy stands between a real server and real
// clients, and nothing is lost or kept back by it. Ends with 77 where the proxy is not installed.
import { execFileSync } from 'node:child_process';
import { createHash, randomBytes } from 'node:crypto';
import { chmodSync, existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { DefaultHttpStack, Upload } from 'tus-js-client';
import WebSocket from 'ws';
import { freePort, start, stop, stopAll } from './processes.mjs';
import { programs, startProxy } from './proxies.mjs';
import { Relay } from './relay.mjs';
import { Client, answerTo, eventually, sleep } from './requests.mjs';

const [proxyName, source, program] = process.argv.slice(2);
if (!existsSync(programs[proxyName])) {
  console.log(`left out: ${proxyName} is not installed (deploy/install.sh)`);
  process.exit(77);
}
const MiB = 1 << 20;
const folder = mkdtempSync(join(tmpdir(), 'divemesh-proxy-'));
chmodSync(folder, 0o755); // nginx's processes are another user's
const ports = { http: await freePort(), https: await freePort(), server: await freePort(), relay: await freePort() };
const outside = `https://localhost:${ports.https}`;
const tus = { 'Tus-Resumable': '1.0.0' };
const sha256 = (bytes) => createHash('sha256').update(bytes).digest();

const expect = (holds, text) => {
  if (!holds) throw new Error(text);
};
const expectStatus = (answer, status, what) =>
  expect(answer.status === status, `${what}: ${answer.status} instead of ${status}: ${answer.body}`);

function makeCertificate() {
  const files = { chain: join(folder, 'chain.pem'), key: join(folder, 'key.pem') };
  execFileSync(
    'openssl',
    [
      'req',
      '-x509',
      '-newkey',
      'ec',
      '-pkeyopt',
      'ec_paramgen_curve:P-256',
      '-nodes',
      '-days',
      '1',
      '-subj',
      '/CN=localhost',
      '-addext',
      'subjectAltName=DNS:localhost',
      '-keyout',
      files.key,
      '-out',
      files.chain,
    ],
    { stdio: 'pipe' },
  );
  return files;
}

const certificate = makeCertificate();
const data = join(folder, 'data');
const token = execFileSync(program, ['token', 'create', '--data', data, '--name', 'test', '--scope', 'admin'], {
  encoding: 'utf8',
  stdio: ['ignore', 'pipe', 'ignore'],
}).split('\n')[0];
const ca = readFileSync(certificate.chain);
const client = new Client(outside, { token, ca, from: '127.0.0.2' });
const direct = new Client(`http://127.0.0.1:${ports.server}`, { token });

const startServer = () =>
  start('server', folder, [
    program,
    'serve',
    '--data',
    data,
    '--listen',
    `127.0.0.1:${ports.server}`,
    '--workers',
    '0',
    '--min-free',
    '100M',
    '--public-url',
    outside,
    '--trusted-proxy',
    '127.0.0.1',
  ]);

const isReady = (from) => () =>
  from.send('GET', '/healthz/ready').then(
    ({ status }) => status === 200,
    () => false,
  );

// Creates an upload through the proxy; returns its path.
async function createUpload(size, metadata) {
  const coded = Object.entries(metadata).map(([name, value]) => `${name} ${Buffer.from(value).toString('base64')}`);
  const answer = await client.send('POST', '/api/v1/uploads', {
    ...tus,
    'Upload-Length': size,
    'Upload-Metadata': coded.join(','),
  });
  expectStatus(answer, 201, 'creating an upload');
  expect(answer.headers.location.startsWith(`${outside}/`), `the location of an upload is ${answer.headers.location}`);
  return new URL(answer.headers.location).pathname;
}
const bodyHeaders = (offset, size) => ({
  ...tus,
  'Upload-Offset': offset,
  'Content-Type': 'application/offset+octet-stream',
  'Content-Length': size,
});

const checks = {
  async 'http is sent to https, with its path and its method'() {
    const plain = new Client(`http://127.0.0.1:${ports.http}`, { token });
    const answer = await plain.send('POST', '/api/v1/uploads?a=b', { Host: 'localhost' });
    expectStatus(answer, 308, 'plain http');
    expect(
      answer.headers.location === 'https://localhost/api/v1/uploads?a=b',
      `it is sent to ${answer.headers.location}`,
    );
    const secure = await client.send('GET', '/healthz/live');
    expect(
      /max-age=\d{7}/.test(secure.headers['strict-transport-security']),
      'browsers are not told to stay with https',
    );
  },

  async 'bytes of an upload are stored before its request has ended, and it goes on after a break'() {
    const bytes = randomBytes(4 * MiB);
    const path = await createUpload(bytes.length, { filename: 'broken.zip', commit: 'yes' });
    const first = client.begin('PATCH', path, bodyHeaders(0, bytes.length));
    first.on('error', () => {});
    // What a proxy keeps back, it keeps back until the body is whole.
    const forth = relay.numBytesForth;
    first.write(bytes.subarray(0, MiB));
    await eventually(() => relay.numBytesForth - forth >= MiB - 65536, 'the proxy passes on the first MiB');
    // A newer request ends the older one: it asks the server itself, so that no proxy can have both.
    const begun = await direct.send('HEAD', path, tus);
    const offset = Number(begun.headers['upload-offset']);
    expect(offset >= MiB / 2, `of the first MiB ${offset} bytes are stored while the request goes on`);
    first.destroy();
    const again = await client.send('HEAD', path, tus);
    expect(Number(again.headers['upload-offset']) === offset, 'the offset changes by the break');
    const rest = await client.send('PATCH', path, bodyHeaders(offset, bytes.length - offset), bytes.subarray(offset));
    expectStatus(rest, 204, 'the rest of the upload');
    expect(rest.headers['divemesh-dive'], 'no answer names the dive');
  },

  async 'a stock tus client uploads in pieces, in two sittings'() {
    const bytes = randomBytes(3 * MiB);
    let dive;
    const sitting = (uploadUrl, giveUpAt) =>
      new Promise((resolve, reject) => {
        const upload = new Upload(bytes, {
          endpoint: `${outside}/api/v1/uploads`,
          uploadUrl,
          chunkSize: MiB / 2,
          retryDelays: null,
          httpStack: new DefaultHttpStack({ ca }),
          headers: { Authorization: `Bearer ${token}` },
          metadata: { filename: 'pieces.zip', commit: 'yes' },
          onAfterResponse: (_request, response) => (dive = response.getHeader('Divemesh-Dive') ?? dive),
          onError: reject,
          onSuccess: () => resolve(upload.url),
          onChunkComplete: (_chunk, accepted) =>
            accepted >= giveUpAt && upload.abort().then(() => resolve(upload.url), reject),
        });
        upload.start();
      });
    const url = await sitting(undefined, MiB);
    await sitting(url, Infinity);
    expect(dive, 'no answer named the dive');
  },

  async 'a large body goes in by one request, and out as it went in, no faster than it is read'() {
    const bytes = randomBytes(96 * MiB);
    const archive = await createUpload(1024, { filename: 'dive.zip', commit: 'yes' });
    const made = await client.send('PATCH', archive, bodyHeaders(0, 1024), randomBytes(1024));
    const dive = made.headers['divemesh-dive'];
    const path = await createUpload(bytes.length, { filename: 'truth.ply', truth: 'reference', dive_id: dive });
    const checksum = `sha256 ${sha256(bytes).toString('base64')}`;
    expectStatus(
      await client.send('PATCH', path, { ...bodyHeaders(0, bytes.length), 'Upload-Checksum': checksum }, bytes),
      204,
      'a body of 96 MiB',
    );

    const truth = JSON.parse((await client.send('GET', `/api/v1/dives/${dive}/truth`)).body).items[0].id;
    const target = `/api/v1/dives/${dive}/truth/${truth}/content`;
    const before = relay.numBytesBack;
    const request = client.begin('GET', target);
    request.end();
    const response = await new Promise((resolve, reject) => request.on('response', resolve).on('error', reject));
    await sleep(1500); // nobody reads
    const taken = relay.numBytesBack - before;
    expect(taken < bytes.length / 2, `the proxy has taken ${Math.round(taken / MiB)} MiB that nobody has read`);
    const hash = createHash('sha256');
    for await (const part of response) hash.update(part);
    expect(hash.digest().equals(sha256(bytes)), 'other bytes come out than went in');
  },

  async 'an event is told, to programs and to pages'() {
    const cookie = await client.send(
      'POST',
      '/api/v1/session',
      { 'Content-Type': 'application/json', Origin: outside },
      '{}',
    );
    const [session] = cookie.headers['set-cookie'] ?? [];
    expect(
      /^__Host-divemesh_session=.*; Secure/.test(session ?? ''),
      `the server does not know that its client speaks TLS: ${session ?? cookie.body}`,
    );
    const kinds = {
      program: { headers: { Authorization: `Bearer ${token}` } },
      page: { headers: { Cookie: session.split(';')[0] }, origin: outside },
    };
    for (const [kind, options] of Object.entries(kinds)) {
      const socket = new WebSocket(`${outside.replace('https', 'wss')}/api/v1/events`, { ca, ...options });
      const told = new Promise((resolve, reject) => {
        socket.on('message', (message) => String(message).includes('upload.created') && resolve(true));
        socket.on('error', reject);
      });
      told.catch(() => {}); // who waits for the connection learns it too
      await new Promise((resolve, reject) => socket.on('open', resolve).on('error', reject));
      await sleep(200);
      await createUpload(1000, { filename: 'event' });
      expect(await Promise.race([told, sleep(20000)]), `a ${kind} is not told of an event`);
      socket.terminate();
    }
  },

  async 'the server learns who its client is, from the proxy alone'() {
    await client.send('GET', '/api/v1/info?fields=version', {
      'X-Forwarded-For': '203.0.113.9',
      Forwarded: 'for=203.0.113.9',
    });
    const line = await eventually(
      () =>
        server
          .log()
          .split('\n')
          .find((each) => each.includes('"/api/v1/info"')),
      'the log has the request',
    );
    const { peer } = JSON.parse(line).data;
    expect(peer === '127.0.0.2', `the server takes 127.0.0.2 for ${peer}`);
  },

  async 'while the server is away clients are told to come back, and then they go on'() {
    await stop(server);
    const away = await client.send('GET', '/healthz/live');
    expect(away.status === 502, `without a server the answer is ${away.status}`);
    server = startServer();
    await eventually(isReady(client), 'the server is reached again');
  },
};

let server = startServer();
const relay = await Relay.start(ports.relay, ports.server);
let failed = 0;
try {
  const proxy = await startProxy[proxyName](source, folder, { ...ports, server: ports.relay, ...certificate });
  await eventually(isReady(direct), 'the server is ready');
  await eventually(isReady(client), `${proxyName} is ready`).catch((error) => {
    throw new Error(`${error.message}\n${proxy.log()}`);
  });
  for (const [name, check] of Object.entries(checks)) {
    const begun = Date.now();
    await check().then(
      () => console.log(`ok: ${name} (${Date.now() - begun} ms)`),
      (error) => {
        failed++;
        console.error(`FAILED: ${name}: ${error.message}`);
      },
    );
  }
  await stop(proxy);
} finally {
  await stopAll();
  rmSync(folder, { recursive: true, force: true });
}
process.exit(failed === 0 ? 0 : 1);
