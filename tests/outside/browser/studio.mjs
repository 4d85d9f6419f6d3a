// Drives the page of `morion studio` in Chromium: a slider, the text, a pixel, hostile text, a build and its end.
//
// usage: node studio.mjs [SCREENSHOTS], with the names of session.mjs
import { join } from "node:path";
import { withStudio } from "./session.mjs";

const shots = process.argv[2];

function hold(is, said) {
  if (!is) throw new Error(said);
  console.log("ok  ", said);
}

await withStudio(async (page, address) => {
  const faults = [];
  const elsewhere = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (told) => { if (/Content Security Policy/.test(told.text())) faults.push(told.text()); });
  page.on("request", (asked) => { if (!/^(blob:|data:|http:\/\/127\.0\.0\.1:)/.test(asked.url())) elsewhere.push(asked.url()); });
  const shot = async (name) => { if (shots) await page.screenshot({ path: join(shots, name + ".png") }); };
  const says = (id, part) => page.waitForFunction(([id, part]) => document.getElementById(id).textContent.includes(part), [id, part], { timeout: 120000 });

  await page.goto(address);
  await page.waitForSelector("#part3d canvas", { timeout: 120000 });
  await says("verdict", "Within the limits");
  // (What follows is measured from a page at rest.)
  await says("size", "as morion render");
  await page.waitForTimeout(3000);
  await shot("wide");

  const slider = page.locator("#key-part\\.width_mm + input[type=range]");
  const began = Date.now();
  await slider.evaluate((range) => { range.value = 70; range.dispatchEvent(new Event("input", { bubbles: true })); });
  await says("size", "while you change it");
  console.log("      a slider's picture after " + (Date.now() - began) + " ms");
  hold((await page.inputValue("#text")).includes("width_mm = 70 "), "a slider changes the text");
  hold((await page.inputValue("#text")).includes("# "), "comments stay");
  await says("size", "as morion render");
  await page.waitForFunction(() => document.querySelector("#part3d canvas"));
  // The part as it stands, in few pixels.
  const stood = () => page.evaluate(() => {
    const small = document.createElement("canvas");
    [small.width, small.height] = [48, 36];
    const context = small.getContext("2d");
    context.drawImage(document.querySelector("#part3d canvas"), 0, 0, 48, 36);
    return [...context.getImageData(0, 0, 48, 36).data];
  });
  const apart = (a, b) => a.reduce((sum, x, k) => sum + Math.abs(x - b[k]), 0) / a.length;
  const home = await stood();
  await page.locator("#part3d canvas").focus();
  for (const key of ["ArrowLeft", "ArrowLeft", "ArrowUp", "+"]) await page.keyboard.press(key);
  const turned = await stood();
  const held = await page.textContent("#part-glb");
  await slider.evaluate((range) => { range.value = 66; range.dispatchEvent(new Event("input", { bubbles: true })); });
  await page.waitForFunction((held) => document.getElementById("part-glb").textContent !== held, held, { timeout: 120000 });
  const [moved, kept] = [apart(home, turned), apart(turned, await stood())];
  hold(moved > 3 * kept, "the part stays as it was turned: " + kept + " of " + moved);

  await page.click("#picture", { position: { x: 100, y: 100 } });
  await says("pixel", "elevation");
  hold(true, "a click tells a pixel's ray");

  const text = await page.inputValue("#text");
  await page.fill("#text", text.replace("base_mm = 5", "base_mm = -5"));
  await says("wrong-part.base_mm", "must be");
  hold(await page.getAttribute("#key-part\\.base_mm", "aria-invalid") === "true", "a fault stands at its field");
  hold(await page.locator("#lines .bad-line").count() === 1, "and at its line");
  await shot("fault");

  const hostile = "<img src=x onerror=document.title=1>";
  await page.fill("#text", text.replace(/summary = .*/, 'summary = "' + hostile + '"').replace("base_mm", hostile.replace(/[= ]/g, "") + " = 1\nbase_mm"));
  await page.waitForSelector("#errors li");
  hold((await page.title()) === "Morion studio" && await page.locator("#errors img").count() === 0, "hostile text stays text");

  await page.fill("#text", text);
  await page.waitForFunction(() => !document.querySelector("#errors li"));
  await page.click("#build");
  await page.waitForFunction(() => !document.getElementById("cancel").disabled);
  await page.click("#cancel");
  await says("build-state", "cancelled");
  await page.click("#build");
  await says("build-state", "verdict");
  hold(await page.locator("#files a").count() > 5, "a build links to its files");
  const [report] = await Promise.all([page.waitForEvent("popup"), page.click("#files a[href*='report.html']")]);
  await report.waitForSelector("#part3d canvas", { timeout: 60000 });
  hold(true, "its report opens, with the part to turn");
  await shot("built");
  // Behind another page a browser draws, and looks, once a second.
  await report.close();
  await page.bringToFront();

  const unnamed = await page.evaluate(() => [...document.querySelectorAll("input, select, textarea, button")]
    .filter((one) => !one.labels?.length && !one.getAttribute("aria-label") && !one.textContent).map((one) => one.id || one.outerHTML));
  hold(unnamed.length === 0, "every field has a label: " + unnamed);
  // A mirror that takes long is followed by a sketch of it, of which the whole picture takes the place.
  await page.selectOption("#shipped", "floor");
  await says("size", "as morion render");
  await says("conclusion", "(smooth mirror):");
  await page.waitForTimeout(3000);
  const wide = page.locator("#key-part\\.width_mm + input[type=range]");
  const slid = Date.now();
  await wide.evaluate((range) => { range.value = Number(range.value) * 1.01; range.dispatchEvent(new Event("input", { bubbles: true })); });
  await says("size", "a sketch of the mirror");
  console.log("      a sketch of floor after " + (Date.now() - slid) + " ms");
  await says("conclusion", "sketch of the mirror");
  await says("size", "as morion render");
  await says("conclusion", "(smooth mirror):");
  hold(true, "a sketch follows a slider, and the mirror itself comes after it");

  await page.setViewportSize({ width: 360, height: 800 });
  await page.emulateMedia({ colorScheme: "dark" });
  hold(await page.evaluate(() => document.documentElement.scrollWidth) <= 360, "it fits 360 pixels");
  await shot("narrow");
  hold(faults.length === 0, "no fault of the page: " + faults);
  hold(elsewhere.length === 0, "nothing comes from elsewhere: " + elsewhere);
});
