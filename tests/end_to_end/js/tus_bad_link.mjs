// node tus_bad_link.mjs FILE ENDPOINT: a stock tus-js-client uploads FILE over a link that breaks,
// and prints the dive that the server made of it. The client has no time limit of its own for a
// link that falls silent: as an application does, this one aborts it and starts it again when
// nothing moves. The token is in DIVEMESH_TOKEN.
import { createReadStream, statSync } from 'node:fs';
import { basename } from 'node:path';
import { Upload } from 'tus-js-client';

const [file, endpoint] = process.argv.slice(2);
const silenceMs = 1000;
let dive = '';
let moved = Date.now();

await new Promise((resolve, reject) => {
  const upload = new Upload(createReadStream(file), {
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
