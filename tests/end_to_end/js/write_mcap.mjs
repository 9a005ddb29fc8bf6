// node write_mcap.mjs DIVE FILE: the images and the IMU of a dive as a robot with ROS 2 records them,
// in MCAP by the writer of mcap.dev, its messages in CDR.
import { open, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { McapWriter } from '@mcap/core';

const [dive, path] = process.argv.slice(2);

// Fields of a message in little-endian CDR: a number begins at a multiple of its size, counted
// behind the four bytes that name the representation.
class Cdr {
  bytes = [0, 1, 0, 0];
  pad(size) {
    while ((this.bytes.length - 4) % size !== 0) this.bytes.push(0);
    return this;
  }
  number(size, set) {
    const view = new DataView(new ArrayBuffer(size));
    set(view);
    this.pad(size).bytes.push(...new Uint8Array(view.buffer));
    return this;
  }
  uint32(value) { return this.number(4, (view) => view.setUint32(0, value, true)); }
  float64s(values) {
    for (const value of values) this.number(8, (view) => view.setFloat64(0, value, true));
    return this;
  }
  string(text) {
    const encoded = new TextEncoder().encode(text);
    this.uint32(encoded.length + 1).bytes.push(...encoded, 0);
    return this;
  }
  header(time, frame) {
    return this.uint32(Number(time / 1000000000n)).uint32(Number(time % 1000000000n)).string(frame);
  }
  with(data = new Uint8Array()) { return Buffer.concat([Buffer.from(this.bytes), data]); }
}

const rows = async (sensor) => {
  const text = await readFile(join(dive, 'mav0', sensor, 'data.csv'), 'utf8');
  const lines = text.split('\n').filter((line) => line && !line.startsWith('#'));
  return lines.map((line) => line.split(',').map((field) => field.trim()));
};

const file = await open(path, 'w');
let position = 0n;
const writer = new McapWriter({
  writable: {
    position: () => position,
    write: async (bytes) => {
      await file.write(bytes);
      position += BigInt(bytes.length);
    },
  },
});
await writer.start({ profile: 'ros2', library: 'divemesh end-to-end test' });
const channel = async (topic, name) => {
  const schema = { name, encoding: 'ros2msg', data: new TextEncoder().encode('# not needed') };
  const schemaId = await writer.registerSchema(schema);
  const info = { schemaId, topic, messageEncoding: 'cdr', metadata: new Map() };
  return writer.registerChannel(info);
};

const messages = [];
for (const [camera, side] of [['cam0', 'left'], ['cam1', 'right']]) {
  const topic = `/stereo/${side}/image_raw/compressed`;
  const id = await channel(topic, 'sensor_msgs/msg/CompressedImage');
  for (const [time, name] of await rows(camera))
    messages.push([BigInt(time), id, async () => {
      const image = await readFile(join(dive, 'mav0', camera, 'data', name));
      const head = new Cdr().header(BigInt(time), side).string('jpeg').uint32(image.length);
      return head.with(image);
    }]);
}
const imu = await channel('/imu/data', 'sensor_msgs/msg/Imu');
const none = Array(9).fill(0);
for (const [time, ...values] of await rows('imu0')) {
  const [wx, wy, wz, ax, ay, az] = values.map(Number);
  const numbers = [0, 0, 0, 1, ...none, wx, wy, wz, ...none, ax, ay, az, ...none];
  messages.push([BigInt(time), imu, async () =>
    new Cdr().header(BigInt(time), 'imu').float64s(numbers).with()]);
}
messages.sort(([a], [b]) => (a < b ? -1 : a > b ? 1 : 0));
for (const [time, channelId, data] of messages) {
  const logTime = time + 2000000n;
  await writer.addMessage({ channelId, sequence: 0, logTime, publishTime: time, data: await data() });
}
await writer.end();
await file.close();
