// A recording is dropped on the page; the tab is loaded again in the middle and the upload goes on; the model appears, and
// a distance that is known is measured in it.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { check_accessibility } from "./accessibility.mjs";
import { address, api, check, dive_folder, in_browser, screenshot, token } from "./browser.mjs";
import { first_hit, triangles_of } from "./rays.mjs";
import { add, place_on, scale, subtract, world_of_truth } from "./world_of_truth.mjs";

const archive = execFileSync("tar", ["-cf", "-", "-C", dive_folder, "."], { maxBuffer: 2 ** 30 });

async function drop(page) {
  await page.evaluate((encoded) => {
    const bytes = Uint8Array.from(atob(encoded), (letter) => letter.charCodeAt(0));
    const transfer = new DataTransfer();
    transfer.items.add(new File([bytes], "tank.tar", { lastModified: 1 }));
    for (const type of ["dragenter", "dragover", "drop"])
      document.body.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
  }, archive.toString("base64"));
  await page.getByRole("dialog").getByRole("combobox").selectOption("fast");
  await page.getByRole("dialog").getByRole("button", { name: "Upload" }).click();
}

async function upload_with_a_reload(page, context) {
  const link = await context.newCDPSession(page);
  const limit = (bytes_per_s) =>
    link.send("Network.emulateNetworkConditions", { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: bytes_per_s });
  await link.send("Network.enable");
  await limit(archive.length / 12);
  await drop(page);
  const sent = page.getByRole("region", { name: "Uploads" }).getByRole("progressbar");
  await page.waitForFunction(() => Number(document.querySelector(".tray [role=progressbar]")?.getAttribute("aria-valuenow")) >= 20);
  await sent.waitFor();
  page.once("dialog", (dialog) => dialog.accept());
  await page.reload();
  await page.getByText("Drop \"tank\" again to go on").waitFor();
  await limit(-1);
  const offsets = [];
  page.on("request", (request) => request.method() === "PATCH" && offsets.push(Number(request.headers()["upload-offset"])));
  await drop(page);
  await page.getByRole("link", { name: "Open the dive" }).click();
  check(offsets[0] > 0, `the upload began again at ${offsets[0]}`);
}

// The same recording as a folder is the same dive: the page knows its identity before it sends.
async function upload_folder(page, dive) {
  await page.locator("#upload-folder").setInputFiles(dive_folder);
  const dialog = page.getByRole("dialog");
  await dialog.getByText(/^\d+ left, \d+ right images · IMU/).waitFor();
  await check_accessibility(page, "the question before an upload");
  await screenshot(page, "offer");
  await dialog.getByRole("combobox").selectOption("");
  await dialog.getByRole("button", { name: "Upload" }).click();
  const opened = await page.getByRole("link", { name: "Open the dive" }).getAttribute("href");
  check(opened === `/dives/${dive.id}`, `the folder became ${opened}, the archive ${dive.id}`);
}

// Returns the number of colours in a picture of the canvas.
async function num_colors(page, canvas) {
  const picture = (await canvas.screenshot()).toString("base64");
  return page.evaluate(async (encoded) => {
    const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(encoded), (letter) => letter.charCodeAt(0))]));
    const drawn = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    drawn.drawImage(bitmap, 0, 0);
    const { data } = drawn.getImageData(0, 0, bitmap.width, bitmap.height);
    const colors = new Set();
    for (let at = 0; at < data.length; at += 4) colors.add((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
    return colors.size;
  }, picture);
}

const artifact_bytes = async (job, name) => {
  const response = await fetch(`${address}/api/v1/jobs/${job}/artifacts/${name}`, { headers: { Authorization: `Bearer ${token}` } });
  return Buffer.from(await response.arrayBuffer());
};
const artifact = async (job, name) => (await artifact_bytes(job, name)).toString();

// Measures the longest edge of a box whose length is known and that the reconstruction measured too: from 15 to 85 % of
// it, so that both ends are on the surface. The page must give what the full mesh has between these places, within 1 %,
// and the true length must lie in the interval that it states.
async function measure_known_length(page, job) {
  const to_world = world_of_truth(dive_folder, await artifact(job, "trajectory.tum"));
  const { distances } = JSON.parse(readFileSync(join(dive_folder, "measurements.json"), "utf8"));
  const measured = JSON.parse(await artifact(job, "metrics.json")).known_distances.distances.filter(({ measured_m }) => measured_m !== null);
  const known = distances.filter(({ name }) => /^box.*(length|width)$/.test(name) && measured.some((each) => each.name === name));
  check(known.length > 0, "no edge of a box was seen in this dive");
  const edge = known.reduce((best, each) => (each.distance_m > best.distance_m ? each : best));
  const [a, b] = [to_world(edge.a), to_world(edge.b)];
  const at = (share) => add(a, scale(subtract(b, a), share));
  const { keyframes } = JSON.parse(await artifact(job, "keyframes.json"));
  const target = at(0.5);
  const range = (keyframe) => Math.hypot(...subtract(keyframe.position_m, target));
  const nearest = keyframes.reduce((best, each) => (range(each) < range(best) ? each : best)).position_m;
  const eye = add(target, scale(subtract(nearest, target), 0.5));

  await page.goto(`${address}/jobs/${job}?view=files`);
  await page.goto(`${address}/jobs/${job}?view=model#camera=${[...eye, ...target].map((value) => value.toFixed(4)).join(",")}`);
  const canvas = page.locator("canvas[data-loaded=true]");
  await canvas.waitFor();
  await page.getByRole("button", { name: "Length", exact: true }).click();
  const box = await canvas.boundingBox();
  for (const share of [0.15, 0.85]) await canvas.click({ position: place_on(box, eye, target, at(share)) });
  const label = page.locator("output.label");
  await label.waitFor();
  await page.waitForTimeout(1500);
  await screenshot(page, "measured");
  const words = await label.textContent();
  const metres = Number(await label.getAttribute("data-value"));
  const truth = 0.7 * edge.distance_m;
  const half = Number(await label.getAttribute("data-half"));
  const triangles = triangles_of(await artifact_bytes(job, "mesh.ply"));
  const [p, q] = [0.15, 0.85].map((share) => first_hit(triangles, eye, at(share)));
  const in_mesh = Math.hypot(...subtract(p, q));
  const report = `${edge.name}: ${words} on the page, ${in_mesh.toFixed(4)} m in mesh.ply, ${truth.toFixed(4)} m in truth`;
  console.log(report);
  check(Math.abs(metres / in_mesh - 1) < 0.01, report);
  check(half > 0 && Math.abs(metres - truth) < half && Math.abs(metres / truth - 1) < 0.05, report);
}

// Somebody without an account opens the link of a result, until it is withdrawn.
async function share_and_withdraw(page) {
  await page.getByRole("button", { name: "Share" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("For whom").fill("museum");
  await dialog.getByRole("button", { name: "Create a link" }).click();
  const link = await dialog.getByRole("textbox", { name: "Create a link" }).inputValue();
  await check_accessibility(page, "sharing");
  await in_browser(
    async ({ page: visitor }) => {
      await visitor.goto(link);
      await visitor.locator("canvas[data-loaded=true]").waitFor();
      check(!visitor.url().includes("dms_"), `the secret is still in the address: ${visitor.url()}`);
      check((await visitor.getByRole("button", { name: "Run again" }).count()) === 0, "a visitor is offered to start a job");
      check((await visitor.getByRole("link", { name: "Dives" }).count()) === 0, "a visitor is offered other dives");
      await screenshot(visitor, "shared");
      await dialog.getByRole("button", { name: "Withdraw" }).click();
      await dialog.getByText(/^withdrawn/).waitFor();
      await visitor.reload();
      await visitor.getByText("This link no longer works").waitFor();
      await visitor.goto(link);
      await visitor.getByText("This link no longer works").waitFor();
    },
    { signed_in: false, expected: [/401/, /403/] },
  );
  await dialog.getByRole("button", { name: "Close" }).click();
}

// Another reconstruction of the dive, without its surface, is put beside the first one: both values, and what differs.
async function beside_another(page, dive, job) {
  const body = { kind: "reconstruct", preset: "fast", options: { surface: false } };
  const other = await api("POST", `/api/v1/dives/${dive.id}/jobs`, body);
  for (let state = other.state; state !== "succeeded"; ) {
    ({ state } = await api("GET", `/api/v1/jobs/${other.id}?wait=30`));
    check(!["failed", "dead", "cancelled"].includes(state), `the second job is ${state}`);
  }
  await page.goto(`${address}/jobs/${job}?view=accuracy`);
  const card = page.getByRole("region", { name: "Beside another result" });
  await card.getByRole("combobox").selectOption(other.id);
  const cells = async (name) =>
    card.getByRole("row").filter({ has: page.getByRole("rowheader", { name, exact: true }) }).getByRole("cell").allTextContents();
  await card.getByRole("rowheader", { name: "Length of the path" }).waitFor();
  check(page.url().includes(`beside=${other.id}`), `the choice is not in the address: ${page.url()}`);
  const area = JSON.parse(await artifact(job, "metrics.json")).mesh.area_m2;
  const [here, there] = await cells("Area of the mesh");
  check(Math.abs(Number.parseFloat(here) / area - 1) < 0.01 && there === "not measured", `area: ${here} beside ${there}`);
  check((await cells("surface"))[1] === "false", `options: ${await cells("surface")}`);
  await card.scrollIntoViewIfNeeded();
  await check_accessibility(page, "two results beside each other");
  await screenshot(page, "beside");
}

// What the recording says of itself is shown, and a dive with a position is on the map.
async function on_the_map(page, dive) {
  const { notes } = JSON.parse(readFileSync(join(dive_folder, "dive.json"), "utf8"));
  check(notes && dive.notes === notes, `notes: "${dive.notes}" on the server, "${notes}" in the recording`);
  await page.goto(`${address}/dives`);
  check((await page.getByRole("button", { name: "Map" }).count()) === 0, "a map of no positions is offered");
  const response = await fetch(`${address}/api/v1/dives/${dive.id}`, {
    method: "PATCH",
    headers: { Authorization: `Bearer ${token}`, "Content-Type": "application/merge-patch+json", "If-Match": "*" },
    body: JSON.stringify({ position: { latitude_deg: 54.3221, longitude_deg: -10.12 } }),
  });
  check(response.ok, `PATCH: ${response.status}`);
  await page.getByRole("button", { name: "Map" }).click();
  await page.getByRole("region", { name: "Map" }).getByRole("button", { name: dive.name }).click();
  await page.getByText("54.32210° N, 10.12000° W").waitFor();
  await check_accessibility(page, "the map of dives");
  await screenshot(page, "map");
  await page.getByRole("region", { name: "Map" }).getByRole("link", { name: dive.name }).click();
  await page.getByText(notes).waitFor();
  await screenshot(page, "facts");
}

await in_browser(async ({ page, context }) => {
  await page.getByRole("heading", { name: "No dives yet" }).waitFor();
  await check_accessibility(page, "the empty list of dives");
  await upload_with_a_reload(page, context);

  await page.getByRole("link", { name: "Reconstruction" }).click();
  await page.getByRole("progressbar").first().waitFor();
  await screenshot(page, "progress");
  await page.getByRole("heading", { name: "Verdict" }).waitFor({ timeout: 240_000 });
  await check_accessibility(page, "a job");
  const job = new URL(page.url()).pathname.split("/").pop();

  await page.getByRole("link", { name: "Model", exact: true }).click();
  const canvas = page.locator("canvas[data-loaded=true]");
  await canvas.waitFor();
  await canvas.press("ArrowLeft");
  await page.waitForFunction(() => window.location.hash.startsWith("#camera="));
  const colors = await num_colors(page, canvas);
  check(colors > 500, `the canvas shows ${colors} colours`);
  await screenshot(page, "model");
  await check_accessibility(page, "the model");
  await measure_known_length(page, job);
  await share_and_withdraw(page);

  for (const tab of ["Mosaic", "Accuracy", "Files", "Log"]) {
    await page.getByRole("navigation").getByRole("link", { name: tab, exact: true }).click();
    await page.waitForTimeout(700);
    await check_accessibility(page, tab);
    await screenshot(page, tab.toLowerCase());
  }
  const [dive] = (await api("GET", "/api/v1/dives")).items;
  await beside_another(page, dive, job);
  await page.goto(`${address}/dives`);
  await upload_folder(page, dive);
  await page.getByRole("link", { name: dive.name }).waitFor();
  await check_accessibility(page, "the list of dives");
  await on_the_map(page, dive);
});
