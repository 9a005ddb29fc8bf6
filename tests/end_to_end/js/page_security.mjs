// What a page of another site, a script that slipped into ours, or a name with markup can do: nothing.
import { createServer } from "node:http";
import { address, api, check, in_browser, screenshot } from "./browser.mjs";

// Another server on this machine: to a browser the same site, so it even sends the cookie along.
const other = createServer((request, response) => {
  response.setHeader("Content-Type", "text/html");
  response.setHeader("Access-Control-Allow-Origin", "*");
  response.end("<!doctype html><title>another site</title>");
});
await new Promise((listening) => other.listen(0, "127.0.0.1", listening));
const other_address = `http://127.0.0.1:${other.address().port}`;

async function another_site_changes_nothing(context) {
  const page = await context.newPage();
  await page.goto(other_address);
  const answered = page.waitForResponse((response) => response.url().startsWith(address));
  await page.evaluate(
    (url) => void fetch(url, { method: "POST", mode: "no-cors", credentials: "include", body: "{}" }).catch(() => {}),
    `${address}/api/v1/queue/redrive`,
  );
  const status = (await answered).status(); // 401: without the cookie
  check(status === 403, `a page of another site was answered with ${status}`);

  const opened = await page.evaluate(
    (url) =>
      new Promise((done) => {
        const socket = new WebSocket(url);
        socket.onopen = () => done(true);
        socket.onerror = () => done(false);
      }),
    `${address.replace("http", "ws")}/api/v1/events`,
  );
  check(!opened, "a page of another site watches the events");
  const read = await page.evaluate(
    (url) => fetch(url, { credentials: "include" }).then((response) => response.text(), () => "refused"),
    `${address}/api/v1/session`,
  );
  check(read === "refused", `a page of another site read ${read}`);
  await page.close();
}

async function another_site_frames_nothing(context) {
  const page = await context.newPage();
  await page.goto(other_address);
  for (const path of ["/", "/dives", "/embed"]) {
    await page.evaluate((url) => {
      const frame = document.createElement("iframe");
      frame.src = url;
      return new Promise((loaded) => ((frame.onload = loaded), document.body.replaceChildren(frame)));
    }, address + path);
    const framed = page.frames().find((frame) => frame !== page.mainFrame());
    check(!framed?.url().startsWith(address), `${path} was shown in a frame`);
  }
  await page.close();
}

async function nothing_foreign_runs(page) {
  const owned = await page.evaluate(async (url) => {
    const inline = document.createElement("script");
    inline.textContent = "window.owned = true";
    document.body.append(inline);
    const image = document.createElement("div");
    image.innerHTML = '<img src="x" onerror="window.owned = true">';
    document.body.append(image);
    const foreign = document.createElement("script");
    foreign.src = url;
    const failed = new Promise((done) => ((foreign.onerror = () => done(true)), (foreign.onload = () => done(false))));
    document.body.append(foreign);
    const sent = await fetch(url).then(() => true, () => false);
    await new Promise((wait) => setTimeout(wait, 300));
    return { ran: window.owned === true, loaded: !(await failed), sent };
  }, other_address);
  check(!owned.ran && !owned.loaded && !owned.sent, `the policy let it: ${JSON.stringify(owned)}`);
}

async function names_with_markup_are_text(page) {
  const name = '<img src="y" onerror="window.owned = true"><b>bold</b>';
  await api("POST", "/api/v1/tokens", { name, scopes: ["dives:read"] });
  await page.goto(`${address}/admin`);
  await page.getByText(name).first().waitFor();
  await screenshot(page, "markup");
  check((await page.locator('img[src="y"]').count()) === 0, "a name was shown as markup");
}

try {
  await in_browser(
    async ({ page, context }) => {
      await another_site_changes_nothing(context);
      await another_site_frames_nothing(context);
      await names_with_markup_are_text(page);
      await nothing_foreign_runs(page);
    },
    { expected: [/Content Security Policy|violates the following/, new RegExp(other_address), /x 404|\/x\b/] },
  );
} finally {
  other.close();
  other.closeAllConnections();
}
