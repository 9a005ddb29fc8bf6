// node write_mcap.mjs DIVE FILE: the images and the IMU of a dive as a robot with ROS 2 records them,
// in MCAP by the writer of mcap.dev, its messages in CDR, and their calibration as CameraInfo.
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

// Returns the numbers behind a key of sensor.yaml, and T_BS as rows.
const numbers = (yaml, key) =>
  new RegExp(`^\\s*${key}: *\\[([^\\]]*)\\]`, 'm').exec(yaml)[1].split(',').map(Number);
const calibration = async (camera) => {
  const yaml = await readFile(join(dive, 'mav0', camera, 'sensor.yaml'), 'utf8');
  const T = numbers(yaml, 'data');
  return {
    size: numbers(yaml, 'resolution'),
    intrinsics: numbers(yaml, 'intrinsics'),
    distortion: [...numbers(yaml, 'distortion_coefficients'), 0],
    axes: [0, 1, 2].map((column) => [T[column], T[4 + column], T[8 + column]]),
    centre: [T[3], T[7], T[11]],
  };
};
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((value) => value / Math.sqrt(dot(a, a)));

// The axes of the rectified cameras in the body: x along the baseline, z ahead.
const cameras = [await calibration('cam0'), await calibration('cam1')];
const baseline = [0, 1, 2].map((i) => cameras[1].centre[i] - cameras[0].centre[i]);
const x = unit(baseline);
const y = unit(cross(cameras[0].axes[2], x));
const rectified = [x, y, cross(x, y)];

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
  const camera_info = await channel(`/stereo/${side}/camera_info`, 'sensor_msgs/msg/CameraInfo');
  const { size, intrinsics: [fx, fy, cx, cy], distortion, axes } = cameras[side === 'left' ? 0 : 1];
  const R = rectified.flatMap((row) => axes.map((axis) => dot(row, axis)));
  const shift = side === 'left' ? 0 : -fx * Math.sqrt(dot(baseline, baseline));
  messages.push([0n, camera_info, async () =>
    new Cdr().header(0n, side).uint32(size[1]).uint32(size[0]).string('plumb_bob')
      .uint32(distortion.length).float64s(distortion).float64s([fx, 0, cx, 0, fy, cy, 0, 0, 1])
      .float64s(R).float64s([fx, 0, cx, shift, 0, fx, cy, 0, 0, 0, 1, 0])
      .uint32(0).uint32(0).uint32(0).uint32(0).uint32(0).uint32(0).with(new Uint8Array(1))]);
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
