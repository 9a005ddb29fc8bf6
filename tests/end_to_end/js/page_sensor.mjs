// A sensor's card is live, then says that its values describe the past, and is live again.
import { check_accessibility } from "./accessibility.mjs";
import { address, api, check, in_browser, screenshot } from "./browser.mjs";

const made = await api("POST", "/api/v1/tokens", { name: "rig-1", scopes: ["sensor:push"], sensor: "rig-1" });
let seq = 0;

const push = (status) =>
  api("POST", "/api/v1/sensors/rig-1/status", { boot_id: "boot-1", messages: [{ seq: seq++, uptime_ms: Math.round(performance.now()), status }] }, made.secret);

await in_browser(async ({ page }) => {
  await push({ battery: 0.82, depth_m: 0.3, recording: true, dive: "wreck" });
  await page.goto(`${address}/sensors`);
  const card = page.getByRole("article");
  await card.getByText("Online").waitFor();
  await card.getByText("82 %").waitFor();
  check((await card.getByText("not measured").count()) > 0, "a value that was not sent is not said to be not measured");
  await check_accessibility(page, "a live card");
  await card.getByText("These values describe the past").waitFor({ timeout: 25_000 });
  check((await card.getByText("Online").count()) === 0, "an old status is shown as online");
  await check_accessibility(page, "an old card");
  await screenshot(page, "old");
  await push({ battery: 0.08 });
  await card.getByText("Online").waitFor();
  await card.getByRole("alert").waitFor();
  await page.getByRole("link", { name: "rig-1" }).click();
  await page.getByRole("heading", { name: "History" }).waitFor();
  await page.getByRole("img", { name: /^History/ }).waitFor();
  await check_accessibility(page, "a sensor's history");
});
