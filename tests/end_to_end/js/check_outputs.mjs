// node check_outputs.mjs FOLDER SCHEMA: mesh.glb by Khronos's validator, metrics.json by its schema.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import Ajv from 'ajv';
import validator from 'gltf-validator';

const [folder, schemaFile] = process.argv.slice(2);
let failed = false;

const report = await validator.validateBytes(new Uint8Array(readFileSync(join(folder, 'mesh.glb'))));
console.log(`mesh.glb: ${report.issues.numErrors} errors, ${report.issues.numWarnings} warnings`);
for (const message of report.issues.messages) {
  if (message.severity > 1) continue;
  console.log(`  ${message.code} at ${message.pointer}: ${message.message}`);
}
failed ||= report.issues.numErrors > 0;

const ajv = new Ajv({ allErrors: true, strict: false });
const validate = ajv.compile(JSON.parse(readFileSync(schemaFile)));
const valid = validate(JSON.parse(readFileSync(join(folder, 'metrics.json'))));
console.log(`metrics.json: ${valid ? 'valid' : 'not valid'}`);
for (const error of validate.errors ?? []) console.log(`  ${error.instancePath} ${error.message}`);
failed ||= !valid;

process.exit(failed ? 1 : 0);
