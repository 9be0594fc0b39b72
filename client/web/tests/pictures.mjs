// node pictures.mjs BUILD FOLDER: pictures of the page against those that the desktop player draws
// offscreen, in each mode. PSNR of all channels, at least 45 dB. KEEP=FOLDER keeps them.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled } from "./browser.mjs";
import { serve } from "./serve.mjs";

const [build, folder] = process.argv.slice(2);
const page = join(build, "web"), pointreel = join(build, "bin/pointreel"), reel = join(folder, "reel");
const LEAST = 45, seconds = "1";
const { server, port } = await serve(page, [reel]);
const browser = await openBrowser("gl-egl");
const scratch = mkdtempSync(join(tmpdir(), "pointreel-"));

const tab = await (await browser.newContext({ viewport: { width: 640, height: 360 } })).newPage();
await tab.goto(`http://127.0.0.1:${port}/${basename(reel)}#t=${seconds}`);

/** Mean squared difference of two pictures, from 0 to 1. */
const difference = (a, b) => tab.evaluate(async ([a, b]) => {
  const [x, y] = await Promise.all([a, b].map(async (text) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const canvas = document.createElement("canvas");
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, image.width, image.height).data;
  }));
  if (x.length !== y.length) throw new Error("pictures of different sizes");
  let sum = 0;
  for (let i = 0; i < x.length; ++i) if (i % 4 !== 3) sum += ((x[i] - y[i]) / 255) ** 2;
  return sum / (0.75 * x.length);
}, [a.toString("base64"), b.toString("base64")]);

for (const floor of [false, true]) {
  for (const mode of ["surfel", "voxel", "point", "strip"]) {
    test(`${mode}s are drawn as on the desktop${floor ? ", with a floor" : ""}`, async () => {
      await tab.evaluate(([mode, floor]) => document.querySelector("pointreel-player").player.set({ mode, floor }), [mode, floor]);
      await settled(tab);
      const bytes = await tab.evaluate(async () => [...new Uint8Array(
        await (await document.querySelector("pointreel-player").player.still()).arrayBuffer())]);
      const own = Buffer.from(bytes), file = join(scratch, `${mode}.png`);
      execFileSync(pointreel, ["play", reel, "--offscreen", "640x360", "--at", seconds, "--mode", mode,
                               floor ? "--floor" : "--no-floor", "--screenshot", file]);
      if (process.env.KEEP) {
        writeFileSync(join(process.env.KEEP, `page-${mode}-${floor}.png`), own);
        writeFileSync(join(process.env.KEEP, `desktop-${mode}-${floor}.png`), readFileSync(file));
      }
      const psnr = -10 * Math.log10(await difference(own, readFileSync(file)));
      console.log(`# ${mode} ${psnr.toFixed(1)} dB`);
      assert.ok(psnr >= LEAST, `${psnr.toFixed(1)} dB`);
    });
  }
}

test.after(async () => {
  await browser.close();
  server.close();
  rmSync(scratch, { recursive: true });
});
