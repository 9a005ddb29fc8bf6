// node check_dockerfiles.mjs SOURCE: the Dockerfiles parse, name the versions they are built on, copy what is
// there, and make images that run as a user without rights, say when they are ill and stop on SIGTERM.
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { validate } from 'dockerfile-utils';
import { Faults } from './faults.mjs';

const [source] = process.argv.slice(2);
const folder = join(source, 'deploy/container');
const faults = new Faults();

// [instruction, rest] of each line, continued lines joined.
const instructionsOf = (text) =>
  text
    .replace(/^#.*\n/gm, '')
    .replace(/\\\n\s*/g, '')
    .split('\n')
    .filter((line) => line.trim())
    .map((line) => line.match(/^(\S+)\s+(.*)$/).slice(1));

function check(name) {
  const text = readFileSync(join(folder, name), 'utf8');
  for (const problem of validate(text)) faults.add(`${name}:${problem.range.start.line + 1}: ${problem.message}`);
  const instructions = instructionsOf(text);
  const stages = ['scratch'];
  for (const [, image, stage] of instructions
    .filter(([word]) => word === 'FROM')
    .map(([, rest]) => rest.match(/^(\S+)(?: AS (\S+))?$/))) {
    faults.expect(stages.includes(image) || /:(?!latest)[^:]+$/.test(image), `${name}: ${image} has no version`);
    stages.push(stage);
  }
  const last = instructions.slice(instructions.map(([word]) => word).lastIndexOf('FROM'));
  const lastOf = (word) => last.filter(([each]) => each === word).at(-1)?.[1];
  faults.expect(lastOf('USER') === '10001:10001', `${name}: runs as ${lastOf('USER') ?? 'root'}`);
  faults.expect(lastOf('HEALTHCHECK')?.includes(' CMD ['), `${name}: has no HEALTHCHECK`);
  faults.expect(lastOf('STOPSIGNAL') === 'SIGTERM', `${name}: does not stop on SIGTERM`);
  for (const [word, rest] of instructions.filter(([each]) => each === 'COPY' || each === 'ADD')) {
    faults.expect(word === 'COPY', `${name}: ADD does more than COPY`);
    if (rest.includes('--from=')) continue;
    for (const path of rest
      .split(/\s+/)
      .filter((each) => !each.startsWith('--'))
      .slice(0, -1))
      faults.expect(existsSync(join(source, path)), `${name}: there is no ${path}`);
  }
  for (const [, rest] of instructions.filter(([word]) => word === 'RUN')) {
    if (!rest.includes('apt-get install')) continue;
    faults.expect(rest.includes('--no-install-recommends'), `${name}: installs what is only recommended`);
    faults.expect(rest.includes('rm -rf /var/lib/apt/lists'), `${name}: keeps the lists of packages`);
  }
}

const names = readdirSync(folder).filter((name) => name.endsWith('Dockerfile'));
names.forEach(check);
faults.expect(names.length >= 3, `there are only ${names.length} Dockerfiles`);

const ignored = readFileSync(join(source, '.dockerignore'), 'utf8').split('\n');
for (const path of ['.git', 'build', '**/node_modules', 'deploy/container/secrets'])
  faults.expect(ignored.includes(path), `.dockerignore: ${path} would get into the build`);
faults.end(names.join(', '));
