// A link signs in once; its secret leaves the address; the page lists the dives and survives a reload.
import { address, check, in_browser, screenshot, sign_in_address } from "./browser.mjs";

await in_browser(
  async ({ page, context }) => {
    const link = await sign_in_address();
    const secret = link.split("#")[1];
    const asked = [];
    page.on("request", (request) => asked.push(request.url()));
    await page.goto(link);
    await page.waitForURL((url) => url.pathname !== "/sign-in");
    check(!page.url().includes(secret), `the secret is still in the address: ${page.url()}`);
    check(!asked.some((url) => new URL(url).pathname.includes(secret) || new URL(url).search.includes(secret)),
      "the secret was sent in an address");

    const [cookie] = (await context.cookies()).filter((each) => each.name === "divemesh_session");
    check(cookie?.httpOnly && cookie.sameSite === "Strict", `the cookie is ${JSON.stringify(cookie)}`);
    check(!(await page.evaluate(() => document.cookie)).includes("divemesh_session"), "a script can read the cookie");
    const kept = await page.evaluate(() => JSON.stringify([{ ...localStorage }, { ...sessionStorage }]));
    check(!kept.includes("dm1_") && !kept.includes("dm_"), `a token is kept in the browser: ${kept}`);

    const dives = () => page.evaluate(async () => (await fetch("/api/v1/dives")).status);
    check((await dives()) === 200, "the page may not list the dives");
    await page.goto(`${address}/dives`);
    await page.locator("body :visible").first().waitFor();
    await screenshot(page, "dives");
    await page.reload();
    check((await dives()) === 200, "a reload has signed the page out");

    const again = await context.newPage();
    const refused = again.waitForResponse((response) => response.url().endsWith("/api/v1/session") && response.request().method() === "POST");
    await again.goto(link);
    check((await refused).status() === 401, "the link signed in twice");
  },
  { signed_in: false },
);
