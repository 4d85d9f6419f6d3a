// How long the studio's picture takes to follow a slider, in Chromium: the median of seven changes of the part's width by half a percent.
//
// usage: node sliders.mjs PROFILE..., with the names of session.mjs; figures are of an idle machine, or mean nothing
import { withStudio } from "./session.mjs";

const CHANGES = 7;

await withStudio(async (page, address) => {
  // At rest the whole picture and the part are there, and nothing more is asked for.
  let last = Date.now();
  page.on("request", () => { last = Date.now(); });
  page.on("requestfinished", () => { last = Date.now(); });
  const rest = async () => {
    await page.waitForFunction(() => /as morion render/.test(document.getElementById("size").textContent), null, { timeout: 120000 });
    while (Date.now() - last < 1500) await page.waitForTimeout(100);
  };
  await page.goto(address);
  await page.waitForSelector("#part3d canvas", { timeout: 120000 });
  await rest();
  for (const name of process.argv.slice(2)) {
    await page.selectOption("#shipped", name);
    await page.waitForTimeout(500);
    await rest();
    const times = [];
    const width = page.locator("#key-part\\.width_mm + input[type=range]");
    const start = Number(await width.inputValue());
    for (let k = 0; k < CHANGES; k++) {
      // From the event to the picture, by the page's own clock.
      times.push(await page.evaluate((wanted) => new Promise((done, failed) => {
        const size = document.getElementById("size");
        const range = document.querySelector("#key-part\\.width_mm + input[type=range]");
        const began = performance.now();
        const watch = new MutationObserver(() => {
          if (!/while you change it|a sketch of the mirror/.test(size.textContent)) return;
          watch.disconnect();
          done(performance.now() - began);
        });
        watch.observe(size, { childList: true, characterData: true, subtree: true });
        setTimeout(() => failed(Error(wanted + " mm brings no picture: " + document.getElementById("errors").textContent)), 20000);
        range.value = wanted;
        range.dispatchEvent(new Event("input", { bubbles: true }));
      }), k % 2 ? start : 1.005 * start));
      await rest();
    }
    times.sort((a, b) => a - b);
    console.log(name.padEnd(24) + "median " + times[CHANGES >> 1].toFixed(0).padStart(4) + " ms, most " + times[CHANGES - 1].toFixed(0) + " ms");
  }
});
