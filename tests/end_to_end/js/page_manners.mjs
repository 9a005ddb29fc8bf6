// A token without scopes, a server that is gone and back, names with markup, and the way out.
import { check_accessibility } from "./accessibility.mjs";
import { address, api, check, in_browser, screenshot, sign_in_address } from "./browser.mjs";

const markup = '<img src=x onerror="window.was_run = true">';
const reader = await api("POST", "/api/v1/tokens", { name: markup, scopes: ["dives:read"] });

await in_browser(async ({ page }) => {
  await page.goto(`${address}/admin`);
  await page.getByText(markup, { exact: true }).waitFor();
  check((await page.locator("img[src=x]").count()) === 0, "the name of a token became an image");
  check(!(await page.evaluate(() => window.was_run)), "the name of a token ran as a script");
  await check_accessibility(page, "the administration");
  for (const path of ["/dives", "/jobs", "/sensors"]) {
    await page.goto(address + path);
    await page.getByRole("heading", { level: 1 }).waitFor();
    await check_accessibility(page, path);
  }
});

await in_browser(
  async ({ page }) => {
    await page.goto(`${address}/sign-in`);
    await page.getByLabel("Access token").fill(`dm_${"0".repeat(64)}`);
    await page.getByRole("button", { name: "Sign in" }).click();
    await page.getByText("This token is not valid").waitFor();
    await check_accessibility(page, "the sign-in");
    await page.getByLabel("Access token").fill(reader.secret);
    await page.getByRole("button", { name: "Sign in" }).click();
    await page.getByText("Your token can look but not upload").waitFor();
    check((await page.getByRole("button", { name: "Upload" }).count()) === 0, "a reader is offered to upload");
    check((await page.getByRole("link", { name: "Administration" }).count()) === 0, "a reader is offered the administration");
    await page.goto(`${address}/admin`);
    await page.getByText("needs a token with the scope admin").waitFor();
    await page.getByText("Display", { exact: true }).click();
    await page.getByRole("button", { name: "Sign out" }).click();
    await page.getByLabel("Access token").waitFor();
    await page.goto(`${address}/dives`);
    await page.getByLabel("Access token").waitFor();
  },
  { signed_in: false, expected: [/401/, /WebSocket/] },
);

await in_browser(
  async ({ page, context }) => {
    await page.goto(`${address}/sensors`);
    await page.getByRole("heading", { name: "No sensor has reported yet" }).waitFor();
    await context.setOffline(true);
    await page.getByText("The server does not answer").first().waitFor();
    await screenshot(page, "gone");
    await context.setOffline(false);
    await page.getByText("The server does not answer").first().waitFor({ state: "detached" });
  },
  { expected: [/ERR_INTERNET_DISCONNECTED/, /WebSocket/] },
);

await in_browser(
  async ({ page }) => {
    await page.emulateMedia({ colorScheme: "dark" });
    await page.goto(await sign_in_address());
    await page.getByRole("heading", { name: "Dives", exact: true }).waitFor();
    check((await page.evaluate(() => document.documentElement.dataset.theme)) === "dark", "the page is not dark");
    await check_accessibility(page, "the dark page");
    await page.getByText("Display", { exact: true }).click();
    await page.getByLabel("Theme").selectOption("sun");
    await check_accessibility(page, "the page for bright sun");
  },
  { signed_in: false, expected: [/401/] },
);
