// node draw_areas.mjs PAGE CLICKS: draws on the page of `divemesh measure --draw` as a person would
// and prints the areas.json that it saves. CLICKS is JSON: [[kind, label, [[x, y], ...]], ...], in
// pixels of an image area of 800 x 600.
import { readFileSync } from 'node:fs';
import { JSDOM, VirtualConsole } from 'jsdom';

const [page, clicks] = process.argv.slice(2);
const complaints = new VirtualConsole();
complaints.on('jsdomError', (error) => {
  if (!/getContext|navigation/i.test(error.message)) throw error; // it paints nothing
});
const { window } = new JSDOM(readFileSync(page, 'utf8'), {
  runScripts: 'dangerously',
  virtualConsole: complaints,
});
const { document } = window;
let saved = null;
window.URL.createObjectURL = (blob) => {
  saved = blob;
  return 'blob:saved';
};

const image = document.getElementById('image');
const send = (type, [x, y]) => {
  const event = new window.MouseEvent(type, { bubbles: true });
  Object.defineProperty(event, 'offsetX', { value: x });
  Object.defineProperty(event, 'offsetY', { value: y });
  image.dispatchEvent(event);
};
for (const [kind, label, points] of JSON.parse(clicks)) {
  document.querySelector(`input[name=kind][value=${kind}]`).click();
  document.getElementById('label').value = label;
  for (const point of points) {
    send('pointerdown', point);
    send('pointerup', point);
  }
  if (kind !== 'quadrat') window.dispatchEvent(new window.KeyboardEvent('keydown', { key: 'Enter' }));
}
document.getElementById('save').click();
if (!saved) throw new Error('nothing was saved: ' + document.getElementById('message').textContent);
const text = await new Promise((resolve) => {
  const reader = new window.FileReader();
  reader.onload = () => resolve(reader.result);
  reader.readAsText(saved);
});
console.log(text);
process.exit(0);
