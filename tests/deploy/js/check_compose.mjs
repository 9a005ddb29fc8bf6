// node check_compose.mjs SOURCE PROGRAM: compose.yaml is one of the Compose specification, refers only to what it
// declares, gives the program options that it has, and lets no container do more than it must.
import { readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import Ajv from 'ajv';
import { parse } from 'yaml';
import { Faults } from './faults.mjs';
import { checkOptions, versionOf } from './program.mjs';

const [source, program] = process.argv.slice(2);
const folder = join(source, 'deploy/container');
const text = readFileSync(join(folder, 'compose.yaml'), 'utf8');
const compose = parse(text, { merge: true });
const version = versionOf(program);
const faults = new Faults();

const { $schema, ...schema } = JSON.parse(
  readFileSync(new URL('node_modules/dclint/schemas/compose.schema.json', import.meta.url)),
);
const isCompose = new Ajv({ strict: false, allErrors: true, validateFormats: false }).compile(schema);
if (!isCompose(compose))
  for (const error of isCompose.errors)
    faults.add(`${error.instancePath} ${error.message} ${JSON.stringify(error.params)}`);

const namesOf = (what) => (Array.isArray(what) ? what : Object.keys(what ?? {}));
const used = { volumes: new Set(), networks: new Set(), secrets: new Set() };
const use = (where, kind, name) => {
  used[kind].add(name);
  faults.expect(compose[kind]?.[name] !== undefined, `${where}: ${kind} ${name} is not declared`);
};

function checkReferences(name, service) {
  for (const volume of service.volumes ?? []) {
    if (typeof volume !== 'string') {
      faults.expect(
        volume.type === 'volume' && volume.target && !volume.source,
        `${name}: ${JSON.stringify(volume)} is no volume of its own`,
      );
      continue;
    }
    use(name, 'volumes', volume.split(':')[0]);
  }
  for (const network of namesOf(service.networks)) use(name, 'networks', network);
  for (const secret of service.secrets ?? []) use(name, 'secrets', secret);
  for (const other of namesOf(service.depends_on)) {
    faults.expect(compose.services[other], `${name}: waits for ${other}, which is not there`);
    faults.expect(
      service.depends_on[other].condition === 'service_healthy',
      `${name}: does not wait until ${other} is healthy`,
    );
  }
  for (const [variable, value] of Object.entries(service.environment ?? {})) {
    if (variable.endsWith('_FILE')) {
      const secret = String(value).match(/^\/run\/secrets\/(\w+)$/)?.[1];
      faults.expect(secret && service.secrets?.includes(secret), `${name}: ${variable} is no secret of this service`);
    } else faults.expect(!/PASSWORD|SECRET|ACCESS_KEY|TOKEN/.test(variable), `${name}: ${variable} is in the file`);
  }
  // Host names in the addresses of other services.
  for (const [, host] of JSON.stringify(service.environment ?? {}).matchAll(
    /(?:@|http:\/\/|"DIVEMESH_UPSTREAM":")([a-z0-9]+)[:/]/g,
  )) {
    const other = compose.services[host];
    faults.expect(other, `${name}: there is no service ${host}`);
    faults.expect(
      namesOf(other?.networks).some((network) => namesOf(service.networks).includes(network)),
      `${name}: cannot reach ${host}`,
    );
  }
}

function checkRights(name, service) {
  faults.expect(/^[1-9]\d*:[1-9]\d*$/.test(service.user), `${name}: runs as ${service.user ?? 'root'}`);
  faults.expect(service.read_only === true, `${name}: can write into its image`);
  faults.expect(service.cap_drop?.includes('ALL') && !service.cap_add, `${name}: has capabilities`);
  faults.expect(service.security_opt?.includes('no-new-privileges:true'), `${name}: can gain privileges`);
  faults.expect(
    !service.privileged && !service.network_mode && !service.pid && !service.devices,
    `${name}: shares what is the host's`,
  );
  faults.expect(
    service.deploy?.resources?.limits?.memory && service.deploy.resources.limits.cpus,
    `${name}: has no limits`,
  );
  faults.expect(service.restart === 'unless-stopped', `${name}: is not started again`);
  faults.expect(/:(?!latest)[^:]+$/.test(service.image), `${name}: ${service.image} has no version`);
  if (service.image.startsWith('divemesh'))
    faults.expect(service.image.endsWith(`:${version}`), `${name}: ${service.image} is not version ${version}`);
  else faults.expect(service.healthcheck?.test, `${name}: nobody asks whether it is healthy`);
  faults.expect(!service.ports || name === 'proxy', `${name}: is reached past the proxy`);
}

for (const [name, service] of Object.entries(compose.services)) {
  checkReferences(name, service);
  checkRights(name, service);
  if (!service.image.startsWith(`divemesh:`)) continue;
  const variables = Object.keys(service.environment).map((variable) => variable.replace(/_FILE$/, ''));
  checkOptions(faults, name, program, service.command, variables);
}
for (const kind of Object.keys(used))
  for (const name of Object.keys(compose[kind]))
    faults.expect(used[kind].has(name), `${kind} ${name} is used by no service`);

const { server, worker, proxy, postgresql } = compose.services;
faults.expect(!server.scale && !server.deploy.replicas, 'server: there must be one');
faults.expect(
  server.environment.DIVEMESH_TRUSTED_PROXY === compose.networks.front.ipam.config[0].subnet,
  'server: does not believe the proxy, or not it alone',
);
faults.expect(
  namesOf(worker.networks).every((network) => compose.networks[network].internal),
  'worker: reaches the internet',
);
faults.expect(!namesOf(proxy.networks).includes('stores'), 'proxy: reaches the stores');
faults.expect(postgresql.image.match(/^postgres:1[56]\./), `postgresql: ${postgresql.image} is not tried`);
const made = readFileSync(join(folder, 'make_secrets.sh'), 'utf8')
  .match(/for name in (.*); do/)[1]
  .split(' ');
for (const [name, secret] of Object.entries(compose.secrets)) {
  faults.expect(made.includes(name), `secret ${name} is not made by make_secrets.sh`);
  faults.expect(
    resolve(folder, secret.file) === join(resolve(folder), 'secrets', name),
    `secret ${name} is not where make_secrets.sh puts it`,
  );
}
for (const service of Object.values(compose.services).filter((each) => each.build))
  readFileSync(resolve(folder, service.build.context, service.build.dockerfile));
faults.end('compose.yaml');
