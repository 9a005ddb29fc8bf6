// node check_mcap.mjs FILE: an exported recording by the reader of mcap.dev, which checks its
// checksums, and its messages by the schemas that it contains.
import { open } from 'node:fs/promises';
import Ajv from 'ajv';
import { McapIndexedReader, McapStreamReader } from '@mcap/core';

const [path] = process.argv.slice(2);
let failed = false;
const complain = (text) => {
  console.log(`  ${text}`);
  failed = true;
};

const file = await open(path);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, size) => {
    const bytes = new Uint8Array(Number(size));
    await file.read(bytes, 0, bytes.length, Number(offset));
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({ readable });
const ajv = new Ajv({ strict: false });
const validators = new Map();
for (const [id, channel] of reader.channelsById) {
  const schema = reader.schemasById.get(channel.schemaId);
  if (channel.messageEncoding !== 'json' || schema.encoding !== 'jsonschema')
    complain(`${channel.topic}: ${channel.messageEncoding}, ${schema.encoding}`);
  const stated = JSON.parse(new TextDecoder().decode(schema.data));
  validators.set(id, ajv.compile({ ...stated, required: Object.keys(stated.properties) }));
}

const counts = {};
let previous = 0n;
for await (const message of reader.readMessages()) {
  const { topic } = reader.channelsById.get(message.channelId);
  counts[topic] = (counts[topic] ?? 0) + 1;
  if (message.logTime < previous) complain(`${topic}: not in the order of time`);
  previous = message.logTime;
  const content = JSON.parse(new TextDecoder().decode(message.data));
  const validate = validators.get(message.channelId);
  if (!validate(content)) complain(`${topic}: ${ajv.errorsText(validate.errors)}`);
  const stamp = BigInt(content.timestamp.sec) * 1000000000n + BigInt(content.timestamp.nsec);
  if (stamp !== message.logTime) complain(`${topic}: stamped ${stamp} at ${message.logTime}`);
  const bytes = content.data === undefined ? null : Buffer.from(content.data, 'base64');
  if (topic === '/cam0/image' && bytes.readUInt16BE(0) !== 0xffd8) complain('no JPEG');
  if (topic === '/cloud' && bytes.length % content.point_stride !== 0) complain('a cut point');
}
for (const topic of ['/pose', '/tf', '/cloud', '/cam0/image', '/cam0/calibration'])
  if (!(counts[topic] > 0)) complain(`no ${topic}`);
let total = 0;
for (const [id, count] of reader.statistics.channelMessageCounts) {
  const { topic } = reader.channelsById.get(id);
  if (BigInt(counts[topic] ?? 0) !== count) complain(`${topic}: ${count} in the statistics`);
  total += Number(count);
}
if (reader.statistics.messageCount !== BigInt(total)) complain('the statistics do not add up');
let certificate = '';
for await (const metadata of reader.readMetadata()) certificate = metadata.metadata.get('certificate');
if (!certificate) complain('no certificate');

// From front to end, as a file without indices is read; it checks the checksum of all data.
const stream = new McapStreamReader({ validateCrcs: true, includeChunks: true });
stream.append(await readable.read(0n, await readable.size()));
for (let record; (record = stream.nextRecord()); );
if (!stream.done()) complain('it does not end');
console.log(`reconstruction.mcap: ${total} messages`);
process.exit(failed ? 1 : 0);
