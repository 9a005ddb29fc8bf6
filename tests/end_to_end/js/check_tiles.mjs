// node check_tiles.mjs FOLDER [textured]: tileset.json and its tiles by the reader of loaders.gl and
// by Khronos's validator, and what the specification says of boxes and errors. Textured tiles carry
// JPEG images, with fewer pixels than those of the tiles below.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { parse } from '@loaders.gl/core';
import { Tiles3DLoader } from '@loaders.gl/3d-tiles';
import validator from 'gltf-validator';

const [folder, expected] = process.argv.slice(2);
let failed = false;
const complain = (text) => {
  console.log(`  ${text}`);
  failed = true;
};

const bytesOf = (name) => {
  const bytes = readFileSync(join(folder, name));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
};
const url = join(folder, 'tileset.json');
const options = { worker: false, '3d-tiles': { isTileset: true } };
const tileset = await parse(bytesOf('tileset.json'), Tiles3DLoader, options, { url, baseUrl: folder });
if (tileset.asset.version !== '1.1') complain(`version ${tileset.asset.version}`);
if (tileset.type !== 'TILES3D') complain(`type ${tileset.type}`);

let numTiles = 0;
let numTextured = 0;
// Returns the pixels of a tile's images.
async function check(tile, parentError) {
  ++numTiles;
  const name = tile.content.uri.split('/').pop();
  if (tile.lodMetricValue > parentError) complain(`${name}: its error is larger than that above`);
  if (tile.refine !== 2) complain(`${name}: refine ${tile.refine}`); // REPLACE
  if (tile.boundingVolume.box?.length !== 12) complain(`${name}: no box`);
  const report = await validator.validateBytes(new Uint8Array(bytesOf(name)));
  for (const message of report.issues.messages)
    if (message.severity === 0) complain(`${name}: ${message.code} at ${message.pointer}`);
  let numPixels = 0;
  for (const { mimeType, image } of report.info.resources ?? []) {
    if (!image) continue;
    if (mimeType !== 'image/jpeg') complain(`${name}: image of type ${mimeType}`);
    numPixels += image.width * image.height;
  }
  if (numPixels > 0) ++numTextured;
  let numBelow = 0;
  for (const child of tile.children ?? []) numBelow += await check(child, tile.lodMetricValue);
  if (numBelow > 0 && numPixels >= numBelow) complain(`${name}: images as large as those below`);
  return numPixels;
}
await check(tileset.root, tileset.lodMetricValue);
if (expected === 'textured' && numTextured === 0) complain('no tile has a texture');
console.log(`tileset.json: ${numTiles} tiles, ${numTextured} with texture`);
process.exit(failed ? 1 : 0);
