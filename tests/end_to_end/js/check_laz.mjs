// node check_laz.mjs LAS LAZ: every point of a LAZ file, as laz-perf decodes it, is that of the LAS
// file of the same mesh: coordinates, colour, sigma, number of observations and all other fields.
import { readFileSync } from 'node:fs';
import { createLazPerf } from 'laz-perf';

const [lasPath, lazPath] = process.argv.slice(2);
const las = readFileSync(lasPath);
const laz = readFileSync(lazPath);
const complain = (text) => {
  console.log(`  ${text}`);
  process.exitCode = 1;
};

// The same offsets in both (LAS 1.4, table 3): steps and origins, bounds, number of points.
for (const [name, begin, end] of [['scale and offset', 131, 179], ['bounds', 179, 227], ['counts', 247, 375]])
  if (las.compare(laz, begin, end, begin, end) !== 0) complain(`${name} differ`);

const pointFormat = las.readUInt8(104);
const length = las.readUInt16LE(105);
const count = Number(las.readBigUInt64LE(247));
const firstPoint = las.readUInt32LE(96);

const lazPerf = await createLazPerf();
const file = lazPerf._malloc(laz.length);
const record = lazPerf._malloc(length);
lazPerf.HEAPU8.set(laz, file);
const reader = new lazPerf.LASZip();
reader.open(file, laz.length);
if (reader.getCount() !== count) complain(`${reader.getCount()} points instead of ${count}`);
if (reader.getPointFormat() !== pointFormat) complain(`point format ${reader.getPointFormat()}`);
if (reader.getPointLength() !== length) complain(`records of ${reader.getPointLength()} bytes`);

const fields = (bytes) => ({
  xyz: [0, 4, 8].map((offset) => bytes.readInt32LE(offset)),
  rgb: [30, 32, 34].map((offset) => bytes.readUInt16LE(offset)),
  sigma: bytes.readFloatLE(36),
  observations: bytes.readUInt32LE(40),
  rest: bytes.subarray(12, 30).toString('hex'),
});
let different = 0;
for (let i = 0; i < count; ++i) {
  reader.getPoint(record);
  const decoded = Buffer.from(lazPerf.HEAPU8.buffer, record, length);
  const begin = firstPoint + i * length;
  if (las.compare(decoded, 0, length, begin, begin + length) === 0) continue;
  if (++different > 3) continue;
  complain(`point ${i}: ${JSON.stringify(fields(decoded))}`);
  complain(`  instead: ${JSON.stringify(fields(las.subarray(begin, begin + length)))}`);
}
console.log(`${lazPath}: ${count} points, ${different} differ; ${laz.length} bytes, LAS ${las.length}`);
process.exit();
