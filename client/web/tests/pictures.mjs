// node pictures.mjs BUILD FOLDER: pictures of the page against those that the desktop player draws
// offscreen: in each mode, with light and false colours, and of scalar fields, whose legends are left out.
// PSNR of all channels, at least 45 dB. KEEP=FOLDER keeps them.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { packFields, writeEnvironment } from "./fields.mjs";
import { serve } from "./serve.mjs";

const [build, folder] = process.argv.slice(2);
const page = join(build, "web"), pointreel = join(build, "bin/pointreel"), reel = join(folder, "reel");
const LEAST = 45, SECONDS = "1", WIDTH = 640, HEIGHT = 360;
const scratch = mkdtempSync(join(tmpdir(), "pointreel-"));

const fields = packFields(build, scratch);
const environment = writeEnvironment(reel);
const { server, port } = await serve(page, [reel, fields]);
const browser = await openBrowser("gl-egl");

async function openReel(path) {
  const tab = await (await browser.newContext({ viewport: { width: WIDTH, height: HEIGHT } })).newPage();
  await tab.goto(`http://127.0.0.1:${port}/${basename(path)}#t=${path === reel ? SECONDS : 0}`);
  return tab;
}
const tabs = new Map([[reel, await openReel(reel)], [fields, await openReel(fields)]]);

/** Mean squared difference of two pictures, from 0 to 1, without so much of their lower left corner. */
const difference = (tab, a, b, [width, height]) => tab.evaluate(async ([a, b, width, height]) => {
  const [x, y] = await Promise.all([a, b].map(async (text) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const canvas = document.createElement("canvas");
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    context.fillRect(0, image.height - height, width, height);
    return context.getImageData(0, 0, image.width, image.height).data;
  }));
  if (x.length !== y.length) throw new Error("pictures of different sizes");
  let sum = 0;
  for (let i = 0; i < x.length; ++i) if (i % 4 !== 3) sum += ((x[i] - y[i]) / 255) ** 2;
  return sum / (0.75 * x.length);
}, [a.toString("base64"), b.toString("base64"), width, height]);

/** `drawing`: what the element and the desktop player are told by the same names. */
async function compare(name, path, drawing, { floor = false, corner = [0, 0] } = {}) {
  const tab = tabs.get(path), file = join(scratch, `${name}.png`);
  await tab.evaluate(([drawing, floor]) => {
    const player = document.querySelector("pointreel-player");
    // The first view leaves room for controls, which the desktop's picture has not.
    if (player.controls) {
      player.controls = false;
      player.player.lookHome();
    }
    for (const key of ["mode", "color", "color-range", "light", "environment", "roughness"]) player.setAttribute(key, drawing[key] ?? "");
    player.player.set({ floor });
  }, [{ ...drawing, ...(drawing.environment ? { environment: `/${basename(reel)}/${basename(environment)}` } : {}) }, floor]);
  if (drawing.environment) await until(tab, () => document.querySelector("pointreel-player").player.light === "environment", "light comes");
  await settled(tab);
  const bytes = await tab.evaluate(async () => [...new Uint8Array(
    await (await document.querySelector("pointreel-player").player.still()).arrayBuffer())]);
  const own = Buffer.from(bytes);
  const options = Object.entries(drawing).flatMap(([key, value]) => [`--${key}`, value]);
  execFileSync(pointreel, ["play", path, "--offscreen", `${WIDTH}x${HEIGHT}`, ...(path === reel ? ["--at", SECONDS] : []),
                           ...options, floor ? "--floor" : "--no-floor", "--screenshot", file]);
  const desktop = readFileSync(file);
  if (process.env.KEEP) {
    writeFileSync(join(process.env.KEEP, `page-${name}.png`), own);
    writeFileSync(join(process.env.KEEP, `desktop-${name}.png`), desktop);
  }
  const psnr = -10 * Math.log10(await difference(tab, own, desktop, corner));
  console.log(`# ${name} ${psnr.toFixed(1)} dB`);
  assert.ok(psnr >= LEAST, `${psnr.toFixed(1)} dB`);
}

const MODES = ["surfel", "voxel", "point", "strip"];
for (const floor of [false, true])
  for (const mode of MODES)
    test(`${mode}s are drawn as on the desktop${floor ? ", with a floor" : ""}`,
         () => compare(`${mode}-${floor}`, reel, { mode }, { floor }));

for (const mode of MODES)
  test(`${mode}s are lit as on the desktop, with shadows on the floor`,
       () => compare(`${mode}-studio`, reel, { mode, light: "studio", roughness: "0.3" }, { floor: true }));
test("a picture of light lights as on the desktop",
     () => compare("surfel-environment", reel, { mode: "surfel", environment, color: "plain" }, { floor: true }));

for (const color of ["normals", "curvature", "accessibility", "depth", "contours"])
  test(`${color} are shown as on the desktop`, () => compare(`surfel-${color}`, reel, { mode: "surfel", color }));
test("contours are lit as on the desktop", () => compare("strip-contours", reel, { mode: "strip", color: "contours", light: "studio" }));

const corner = [220, 120];
for (const mode of ["surfel", "voxel"]) {
  for (const range of [undefined, "500,1500"])
    test(`numbers of ${mode}s have the desktop's colours${range ? " between chosen ends" : ""}`,
         () => compare(`${mode}-intensity-${range ? "range" : "all"}`, fields,
                       { mode, color: "intensity", ...(range ? { "color-range": range } : {}) }, { corner }));
  test(`labels of ${mode}s have the desktop's colours`,
       () => compare(`${mode}-class`, fields, { mode, color: "class" }, { corner }));
}

test.after(async () => {
  await browser.close();
  server.close();
  rmSync(scratch, { recursive: true });
});
