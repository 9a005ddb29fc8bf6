// node tus_reference_server.mjs FOLDER: @tus/server with its file store over FOLDER, at
// /api/v1/uploads of a free port of loopback, which it prints.
import { createRequire } from 'node:module';

const packages = createRequire(new URL('../end_to_end/js/package.json', import.meta.url));
const { Server } = packages('@tus/server');
const { FileStore } = packages('@tus/file-store');

const [directory] = process.argv.slice(2);
const server = new Server({
  path: '/api/v1/uploads',
  relativeLocation: true,
  datastore: new FileStore({ directory }),
});
const http = server.listen({ host: '127.0.0.1', port: 0 }, () => console.log(`port ${http.address().port}`));
