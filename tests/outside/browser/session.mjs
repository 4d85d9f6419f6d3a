// The browser, and the studio in it, of which a check opens pages: Chromium without a graphics card, and a server in a folder of its own.
//
// MORION names the program, CHROMIUM the browser.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

// Chromium, which draws in software.
export function launched() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM || "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
  });
}

// Does `work` with a page, on which nothing is open yet, and the address of a studio; both are gone after it.
export async function withStudio(work) {
  const folder = mkdtempSync(join(tmpdir(), "studio-"));
  const program = process.env.MORION || "morion";
  const child = spawn(program, ["studio", "--no-open", "--out", folder], { stdio: ["ignore", "pipe", "inherit"] });
  let browser;
  try {
    const address = await new Promise((found) => child.stdout.once("data", (line) => found(String(line).trim())));
    browser = await launched();
    await work(await browser.newPage({ viewport: { width: 1500, height: 1000 } }), address);
  } finally {
    await browser?.close();
    child.kill();
    rmSync(folder, { recursive: true, force: true });
  }
}
