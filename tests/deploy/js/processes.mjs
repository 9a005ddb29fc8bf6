// The processes of a test, which end with it.
import { spawn } from 'node:child_process';
import { createServer } from 'node:net';
import { createWriteStream, readFileSync } from 'node:fs';
import { join } from 'node:path';

const started = [];

// Starts a program that writes all it says to FOLDER/NAME.log; `log()` is that text. It ends with this process,
// however that ends.
export function start(name, folder, command, environment = {}) {
  const file = join(folder, `${name}.log`);
  const out = createWriteStream(file);
  const child = spawn('setpriv', ['--pdeathsig', 'TERM', ...command], {
    env: { ...process.env, ...environment },
    cwd: folder,
  });
  child.stdout.pipe(out);
  child.stderr.pipe(out);
  const ended = new Promise((resolve) => child.on('exit', resolve));
  const running = { name, child, ended, log: () => readFileSync(file, 'utf8') };
  child.on('error', (error) => console.error(`${name}: ${error.message}`));
  started.push(running);
  return running;
}

export async function stop({ child, ended }) {
  if (child.exitCode === null && child.signalCode === null) child.kill('SIGTERM');
  const late = setTimeout(() => child.kill('SIGKILL'), 15000);
  await ended;
  clearTimeout(late);
}

export async function stopAll() {
  await Promise.all(started.map(stop));
}

export function freePort() {
  return new Promise((resolve, reject) => {
    const server = createServer();
    server.on('error', reject);
    server.listen(0, '127.0.0.1', () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
}
