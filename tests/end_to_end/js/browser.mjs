// Chromium with the page of a server, for the scripts page_*.mjs:
//
//   await in_browser(async ({ page }) => { ... });
//
// `page` (Playwright) is signed in. The script fails if the function throws, an error reaches the page or its console,
// or the page asks another server. Screenshots go to the folder DIVEMESH_SCREENSHOTS.
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { chromium } from "playwright-core";

const arguments_of_chromium = [
  "--no-sandbox",
  "--disable-gpu",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-quic",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--disable-dev-shm-usage", // a container has little of it
  "--no-first-run",
];

export const [address, token, dive_folder] = process.argv.slice(2);
const name = basename(process.argv[1], ".mjs");

// Asks the API with the administrator's token, or another one; returns the answer, which must be a success.
export async function api(method, path, body, with_token = token) {
  const response = await fetch(address + path, {
    method,
    headers: { Authorization: `Bearer ${with_token}`, "Content-Type": "application/json", "If-Match": "*" },
    body: body === undefined ? undefined : JSON.stringify(body),
  });
  if (!response.ok) throw new Error(`${method} ${path}: ${response.status} ${await response.text()}`);
  return response.status === 204 ? null : response.json();
}

// Returns the address that signs a browser in, once.
export async function sign_in_address(with_token = token) {
  const made = await api("POST", "/api/v1/one_shot_tokens", { path: "/api/v1/session" }, with_token);
  return `${address}/sign-in#${made.secret}`;
}

export function check(condition, message) {
  if (!condition) throw new Error(message);
}

export async function screenshot(page, what) {
  const folder = process.env.DIVEMESH_SCREENSHOTS;
  if (!folder) return;
  mkdirSync(folder, { recursive: true });
  await page.screenshot({ path: join(folder, `${name}-${what}.png`) });
}

// That nobody is signed in, when the page is opened.
const not_signed_in = /console: .* 401 .*\/api\/v1\/session$/;

// What went wrong in the page. What a script expects is taken by its pattern in `expected`.
function watch(page, expected) {
  const faults = [];
  const note = (fault) => [not_signed_in, ...expected].some((pattern) => pattern.test(fault)) || faults.push(fault);
  page.on("pageerror", (error) => note(`error: ${error.stack ?? error}`));
  page.on("console", (message) => message.type() === "error" && note(`console: ${message.text()} ${message.location().url}`));
  page.on("request", (request) => {
    const url = request.url();
    if (/^(https?|wss?):/.test(url) && new URL(url).host !== new URL(address).host) note(`asked another server: ${url}`);
  });
  return faults;
}

export async function in_browser(run, { expected = [], signed_in = true, ...options } = {}) {
  const profile = mkdtempSync(join(tmpdir(), "divemesh-chromium-"));
  let context;
  try {
    context = await chromium.launchPersistentContext(profile, {
      executablePath: process.env.DIVEMESH_CHROMIUM ?? "/usr/bin/chromium",
      args: arguments_of_chromium,
      viewport: { width: 1280, height: 800 },
      ...options,
    });
    context.setDefaultTimeout(30_000);
    const page = context.pages()[0] ?? (await context.newPage());
    const faults = watch(page, expected);
    try {
      if (signed_in) {
        await page.goto(await sign_in_address());
        await page.waitForURL((url) => url.pathname !== "/sign-in");
      }
      await run({ page, context, faults });
      check(faults.length === 0, faults.join("\n"));
    } catch (error) {
      await screenshot(page, "failed").catch(() => {});
      throw faults.length > 0 ? new Error(`${error.message}\nthe page:\n${faults.join("\n")}`, { cause: error }) : error;
    }
  } finally {
    await context?.close();
    rmSync(profile, { recursive: true, force: true, maxRetries: 3 });
  }
}
