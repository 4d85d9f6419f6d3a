// Opens pages in Chromium, as people do: nothing is said on the console, nothing is fetched, a drag and a key turn the
// part, no text runs out of a telephone's width, print has no empty page, and axe-core finds no serious fault.
//
// usage: node pages.mjs SCREENSHOTS PAGE.html...
import { readFileSync } from "node:fs";
import { basename, dirname, join, resolve } from "node:path";
import { createRequire } from "node:module";
import { launched } from "./session.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const [shots, ...pages] = process.argv.slice(2);

// What is wrong with a page, and how it looks.
async function faults(browser, file, { width, colorScheme }) {
  const wrong = [];
  const page = await browser.newPage({ viewport: { width, height: 900 }, colorScheme });
  // (Chromium's own notes on drawing without a graphics card are no fault of the page.)
  page.on("console", (said) => {
    if (["error", "warning"].includes(said.type()) && !/GL Driver Message|GPU stall/.test(said.text())) {
      wrong.push(`console: ${said.text()}`);
    }
  });
  page.on("pageerror", (error) => wrong.push(`script: ${error.message}`));
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) wrong.push(`fetches ${request.url()}`);
  });
  await page.goto(`file://${resolve(file)}`);
  const part = page.locator("#part3d canvas");
  if (await page.locator("#part3d").count()) {
    await part.waitFor({ timeout: 10000 }).catch(() => wrong.push("no part to turn"));
    if (await part.count()) wrong.push(...await turned(page, part));
  }
  const over = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  if (over > 0) wrong.push(`${over} px wider than the window`);
  await page.evaluate(axe);
  const found = await page.evaluate(() => window.axe.run());
  for (const { id, impact, nodes } of found.violations) {
    if (["serious", "critical"].includes(impact)) {
      wrong.push(`axe: ${id} at ${nodes.map((node) => node.target.join(" ")).slice(0, 3).join(", ")}`);
    }
  }
  const name = `${basename(dirname(resolve(file)))}-${basename(file, ".html")}-${width}-${colorScheme}.png`;
  await page.screenshot({ path: join(shots, name), fullPage: true });
  await page.close();
  return wrong;
}

// Whether a drag and a key change what the canvas shows.
async function turned(page, part) {
  const seen = () => part.evaluate((canvas) => canvas.toDataURL());
  await part.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await part.boundingBox();
  const wrong = [];
  const first = await seen();
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.mouse.down();
  await page.mouse.move(x + width / 2 + 90, y + height / 2 - 30, { steps: 4 });
  await page.mouse.up();
  const dragged = await seen();
  if (dragged === first) wrong.push("a drag does not turn the part");
  await part.press("ArrowLeft");
  if (await seen() === dragged) wrong.push("a key does not turn the part");
  await part.press("Home");
  return wrong;
}

if (!shots || pages.length === 0) {
  console.error("usage: node pages.mjs SCREENSHOTS PAGE.html...");
  process.exit(2);
}
const browser = await launched();
let failed = 0;
for (const file of pages) {
  for (const looks of [{ width: 1280, colorScheme: "light" }, { width: 360, colorScheme: "dark" }]) {
    const wrong = await faults(browser, file, looks);
    failed += wrong.length;
    console.log(`chromium: ${file} ${looks.width} px, ${looks.colorScheme}: ${wrong.length ? `FAILED: ${wrong.join("; ")}` : "ok"}`);
  }
}
await browser.close();
process.exit(failed ? 1 : 0);
