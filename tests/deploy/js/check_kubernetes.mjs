// node check_kubernetes.mjs SOURCE PROGRAM: the manifests are what Kubernetes knows, refer only to what is there,
// give the program options that it has, and let no pod do more than it must.
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import ts from 'typescript';
import { parseAllDocuments } from 'yaml';
import { Faults } from './faults.mjs';
import { checkOptions, versionOf } from './program.mjs';

const [source, program] = process.argv.slice(2);
const folder = join(source, 'deploy/kubernetes');
const here = dirname(fileURLToPath(import.meta.url));
const faults = new Faults();
const version = versionOf(program);

const load = (file) => parseAllDocuments(readFileSync(join(folder, file), 'utf8')).map((document) => document.toJS());
const [kustomization] = load('kustomization.yaml');
const files = readdirSync(folder).filter((file) => file.endsWith('.yaml') && file !== 'kustomization.yaml');
const objects = files.flatMap((file) => load(file).map((object) => ({ file, ...object })));
const named = (kind, name) => objects.find((object) => object.kind === kind && object.metadata.name === name);
const first = (kind) => objects.find((object) => object.kind === kind);

// What kustomization.yaml makes of secrets.env.
const secretKeys = readFileSync(join(folder, 'secrets.env.example'), 'utf8')
  .trim()
  .split('\n')
  .map((line) => line.split('=')[0]);
const [secret] = kustomization.secretGenerator;

const moduleOf = (object) => `kubernetes-models/${object.apiVersion}`;

// The types of the API as TypeScript has them: fields that it does not know are errors there.
function checkTypes() {
  const typed = mkdtempSync(join(here, 'typed-'));
  try {
    const source = objects.map(
      ({ file, ...object }, index) =>
        `import { I${object.kind} as T${index} } from '${moduleOf(object)}/${object.kind}';\nexport const object${index}: T${index} = ${JSON.stringify(object)};\n`,
    );
    const path = join(typed, 'objects.ts');
    writeFileSync(path, source.join(''));
    const made = ts.createProgram([path], {
      noEmit: true,
      strict: true,
      skipLibCheck: true,
      moduleResolution: ts.ModuleResolutionKind.Node10,
      target: ts.ScriptTarget.ES2020,
      types: [],
    });
    for (const problem of ts.getPreEmitDiagnostics(made)) {
      const line = problem.file?.getLineAndCharacterOfPosition(problem.start).line ?? 0;
      faults.add(
        `${objects[Math.floor(line / 2)]?.file}: ${ts.flattenDiagnosticMessageText(problem.messageText, ' ')}`,
      );
    }
  } finally {
    rmSync(typed, { recursive: true });
  }
}

// And their schemas, which know formats and ranges.
function checkSchema({ file, ...object }) {
  const Model = createRequire(import.meta.url)(moduleOf(object))[object.kind];
  try {
    new Model(object).validate();
  } catch (error) {
    faults.add(`${file}: ${error.message}`);
  }
}

function checkContainer(where, pod, container) {
  const rights = { ...pod.securityContext, ...container.securityContext };
  faults.expect(rights.runAsNonRoot === true && rights.runAsUser === 10001, `${where}: may run as root`);
  faults.expect(rights.readOnlyRootFilesystem === true, `${where}: can write into its image`);
  faults.expect(
    rights.allowPrivilegeEscalation === false && rights.capabilities?.drop?.includes('ALL') && !rights.capabilities.add,
    `${where}: has privileges`,
  );
  faults.expect(rights.seccompProfile?.type === 'RuntimeDefault', `${where}: may call all of the kernel`);
  faults.expect(container.resources?.limits?.memory && container.resources.requests?.cpu, `${where}: has no limits`);
  const image = kustomization.images.find(({ name }) => name === container.image);
  const tag = image ? image.newTag : container.image.split(':')[1];
  faults.expect(String(tag) === version, `${where}: its image is not version ${version} but ${tag}`);

  const variables = [];
  for (const { configMapRef, secretRef } of container.envFrom ?? []) {
    if (configMapRef) {
      const map = named('ConfigMap', configMapRef.name);
      faults.expect(map, `${where}: there is no ConfigMap ${configMapRef.name}`);
      variables.push(...Object.keys(map?.data ?? {}));
    }
    if (secretRef) {
      faults.expect(secretRef.name === secret.name, `${where}: there is no Secret ${secretRef.name}`);
      variables.push(...secretKeys);
    }
  }
  for (const variable of container.env ?? [])
    faults.expect(variable.valueFrom, `${where}: ${variable.name} is in the file`);
  checkOptions(faults, where, program, container.args, variables);

  const volumes = (pod.volumes ?? []).map(({ name }) => name);
  const mounted = (container.volumeMounts ?? []).map(({ name }) => name);
  for (const name of mounted) faults.expect(volumes.includes(name), `${where}: there is no volume ${name}`);
  for (const name of volumes) faults.expect(mounted.includes(name), `${where}: volume ${name} is mounted nowhere`);
  const ports = (container.ports ?? []).map(({ name }) => name);
  for (const probe of ['startupProbe', 'livenessProbe', 'readinessProbe'])
    if (container[probe])
      faults.expect(ports.includes(container[probe].httpGet.port), `${where}: ${probe} asks a port that is not there`);
}

function checkPod(object) {
  const pod = object.spec.template.spec;
  const where = object.file;
  faults.expect(pod.automountServiceAccountToken === false, `${where}: gets a token of the cluster`);
  faults.expect(pod.enableServiceLinks === false, `${where}: gets variables that look like options`);
  faults.expect(!pod.hostNetwork && !pod.hostPID && !pod.hostIPC, `${where}: shares what is the node's`);
  for (const volume of pod.volumes ?? []) {
    faults.expect(!volume.hostPath, `${where}: mounts a folder of the node`);
    const claim = volume.persistentVolumeClaim?.claimName;
    if (claim) faults.expect(named('PersistentVolumeClaim', claim), `${where}: there is no claim ${claim}`);
  }
  for (const container of pod.containers) checkContainer(where, pod, container);
}

const pods = objects.filter((object) => object.spec?.template?.spec?.containers);
const matches = (selector, labels) => Object.entries(selector).every(([name, value]) => labels[name] === value);
const selects = (where, selector) => {
  const found = pods.filter((object) => matches(selector, object.spec.template.metadata.labels));
  faults.expect(found.length > 0, `${where}: selects no pod`);
  return found;
};

function checkSelections() {
  for (const object of objects.filter(({ kind }) => kind === 'Deployment'))
    faults.expect(
      selects(object.file, object.spec.selector.matchLabels)[0] === object,
      `${object.file}: selects other pods than its own`,
    );
  for (const object of objects.filter(({ kind }) => kind === 'PodDisruptionBudget'))
    selects(object.file, object.spec.selector.matchLabels);
  for (const object of objects.filter(({ kind }) => kind === 'NetworkPolicy'))
    selects(object.file, object.spec.podSelector.matchLabels);
  for (const object of objects.filter(({ kind }) => kind === 'Service'))
    for (const { targetPort } of object.spec.ports)
      for (const pod of selects(object.file, object.spec.selector))
        faults.expect(
          pod.spec.template.spec.containers[0].ports?.some(({ name }) => name === targetPort),
          `${object.file}: there is no port ${targetPort}`,
        );
  for (const { host, http } of first('Ingress').spec.rules) {
    faults.expect(
      first('Ingress').spec.tls.some(({ hosts }) => hosts.includes(host)),
      `ingress.yaml: ${host} is not behind TLS`,
    );
    for (const { backend } of http.paths) {
      const service = named('Service', backend.service.name);
      faults.expect(
        service?.spec.ports.some(({ name }) => name === backend.service.port.name),
        `ingress.yaml: there is no ${backend.service.name}`,
      );
    }
  }
  const { scaleTargetRef, metrics } = first('HorizontalPodAutoscaler').spec;
  const target = named('Deployment', scaleTargetRef.name);
  faults.expect(
    target && target.spec.replicas === undefined,
    'worker-autoscaler.yaml: its target is not there, or has a number of its own',
  );
  const text = readFileSync(join(folder, 'worker-autoscaler.yaml'), 'utf8');
  faults.expect(
    text.includes(`{ as: ${metrics[0].external.metric.name} }`),
    'worker-autoscaler.yaml: the rule makes another metric',
  );
  const series = text.match(/seriesQuery: (\w+)/)[1];
  faults.expect(
    readFileSync(join(source, 'api/metrics.cpp'), 'utf8').includes(`"${series}"`),
    `worker-autoscaler.yaml: the server has no metric ${series}`,
  );
}

checkTypes();
objects.forEach(checkSchema);
pods.forEach(checkPod);
checkSelections();

for (const file of files)
  faults.expect(
    kustomization.resources.includes(file) || file === 'first-token.yaml',
    `${file} is in no kustomization`,
  );
for (const file of kustomization.resources)
  faults.expect(existsSync(join(folder, file)), `kustomization.yaml: there is no ${file}`);
const server = named('Deployment', 'divemesh-server');
faults.expect(
  server.spec.replicas === 1 && server.spec.strategy.type === 'Recreate',
  'server.yaml: there must be one server at a time',
);
const deployed = objects.filter(({ kind }) => kind === 'Deployment').map(({ spec }) => spec.template.metadata.labels);
const policy = named('NetworkPolicy', 'divemesh').spec;
faults.expect(
  deployed.every((labels) => matches(policy.podSelector.matchLabels, labels)) && policy.ingress.length === 0,
  'network.yaml: some pods may do everything',
);
faults.end(`${objects.length} objects in ${files.length} files`);
