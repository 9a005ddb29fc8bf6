// node tus_bad_link.mjs FILE ENDPOINT [browser]: a stock tus-js-client uploads FILE over a link that
// breaks, and prints the dive that the server made of it. Its build for Node, or its build for
// browsers in a page of http://lab.example (jsdom, which asks the server for leave as browsers do).
// The client has no time limit of its own for a link that falls silent: as an application does,
// this one aborts it and starts it again when nothing moves. The token is in DIVEMESH_TOKEN.
import { createReadStream, readFileSync, statSync } from 'node:fs';
import { createRequire } from 'node:module';
import { basename } from 'node:path';
import { JSDOM } from 'jsdom';
import { Upload } from 'tus-js-client';

const [file, endpoint, build] = process.argv.slice(2);
const silenceMs = 1000;
let dive = '';
let moved = Date.now();

const inBrowser = () => {
  const { window } = new JSDOM('', { url: 'http://lab.example/', runScripts: 'outside-only' });
  const client = createRequire(import.meta.url).resolve('tus-js-client/dist/tus.js');
  window.eval(readFileSync(client, 'utf8'));
  return [window.tus.Upload, new window.File([readFileSync(file)], basename(file))];
};
const [Client, source] = build === 'browser' ? inBrowser() : [Upload, createReadStream(file)];

await new Promise((resolve, reject) => {
  const upload = new Client(source, {
    endpoint,
    uploadSize: statSync(file).size,
    chunkSize: 1 << 20,
    retryDelays: Array(50).fill(50),
    headers: { Authorization: `Bearer ${process.env.DIVEMESH_TOKEN}` },
    metadata: { filename: basename(file), commit: 'yes' },
    onAfterResponse: (_request, response) => {
      dive = response.getHeader('Divemesh-Dive') ?? dive;
    },
    onProgress: () => {
      moved = Date.now();
    },
    onError: reject,
    onSuccess: resolve,
  });
  const watch = setInterval(() => {
    if (dive) clearInterval(watch);
    if (dive || Date.now() - moved < silenceMs) return;
    moved = Date.now();
    upload.abort().then(() => upload.start(), reject);
  }, 100);
  upload.start();
});
if (!dive) throw new Error('no answer named the dive');
console.log(dive);
process.exit(0); // connections that fell silent are still open
