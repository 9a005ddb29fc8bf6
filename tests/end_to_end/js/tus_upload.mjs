// node tus_upload.mjs FILE ENDPOINT: a stock tus-js-client uploads FILE in two sittings, the second
// one going on where the first was given up, and prints the dive that the server made of it.
// The token is in DIVEMESH_TOKEN.
import { createReadStream, mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { FileUrlStorage, Upload } from 'tus-js-client';

const [file, endpoint] = process.argv.slice(2);
const size = statSync(file).size;
const state = mkdtempSync(join(tmpdir(), 'divemesh-tus-'));
const urlStorage = new FileUrlStorage(join(state, 'uploads.json'));
let dive = '';

// Resolves with the offset at which this sitting began; ends at `giveUpAt` bytes.
const sitting = (giveUpAt) =>
  new Promise((resolve, reject) => {
    let begunAt;
    const upload = new Upload(createReadStream(file), {
      endpoint,
      urlStorage,
      uploadSize: size,
      chunkSize: Math.ceil(size / 8),
      retryDelays: [0, 200],
      fingerprint: async () => file,
      headers: { Authorization: `Bearer ${process.env.DIVEMESH_TOKEN}` },
      metadata: { filename: basename(file), commit: 'yes' },
      onAfterResponse: (_request, response) => {
        dive = response.getHeader('Divemesh-Dive') ?? dive;
      },
      onError: reject,
      onSuccess: () => resolve(begunAt),
      onChunkComplete: (chunk, accepted) => {
        begunAt ??= accepted - chunk;
        if (accepted >= giveUpAt && accepted < size) upload.abort().then(() => resolve(begunAt), reject);
      },
    });
    upload.findPreviousUploads().then((previous) => {
      if (previous.length > 0) upload.resumeFromPreviousUpload(previous[0]);
      upload.start();
    }, reject);
  });

try {
  await sitting(size / 4);
  const begunAt = await sitting(Infinity);
  if (!(begunAt >= size / 4)) throw new Error(`the second sitting began at byte ${begunAt} of ${size}`);
  if (!dive) throw new Error('no answer named the dive');
  console.log(dive);
} finally {
  rmSync(state, { recursive: true });
}
