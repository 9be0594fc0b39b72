// node headset.mjs BUILD FOLDER: the page with a headset, which npm's iwer emulates. SHOTS=FOLDER keeps
// pictures of what both eyes see.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { serve } from "./serve.mjs";
import { ask } from "./tab.mjs";

const [build, folder] = process.argv.slice(2), page = join(build, "web"), reel = join(folder, "reel");
const { server, port } = await serve(page, [reel]);
const browser = await openBrowser();
const emulator = readFileSync(new URL("node_modules/iwer/build/iwer.min.js", import.meta.url), "utf8");

/** `emulation`: what is done before the page loads. */
async function open(emulation) {
  const tab = await (await browser.newContext({ viewport: { width: 800, height: 400 } })).newPage();
  tab.faults = [];
  tab.on("pageerror", (error) => tab.faults.push(error.message));
  await tab.addInitScript(emulation);
  await tab.goto(`http://127.0.0.1:${port}/${basename(reel)}#t=0`);
  await settled(tab);
  return { tab, close: async () => {
    assert.deepEqual(tab.faults, []);
    await tab.context().close();
  } };
}
const emulated = `${emulator}
  window.device = new IWER.XRDevice(IWER.metaQuest3, { stereoEnabled: true });
  device.installRuntime({ forceInstall: true });`;

/**
 * What each eye sees: of the pixels unlike the upper left corner, how many there are, and their mean column, as a share of the
 * eye's width.
 */
const eyes = (tab) => tab.evaluate(() => new Promise((resolve) => {
  const session = document.querySelector("pointreel-player").player.display.session;
  session.requestAnimationFrame(() => {
    const gl = session.renderState.baseLayer.context, { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const pixels = new Uint8Array(4 * width * height), half = width / 2;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    resolve([0, half].map((first) => {
      let count = 0, columns = 0;
      for (let y = 0; y < height; ++y) {
        for (let x = first; x < first + half; ++x) {
          const i = 4 * (y * width + x), corner = 4 * (height - 1) * width;
          if ([0, 1, 2].every((c) => Math.abs(pixels[i + c] - pixels[corner + c]) < 8)) continue;
          ++count;
          columns += x - first;
        }
      }
      return { count, column: columns / count / half };
    }));
  });
}));
const entered = (tab) => until(tab, () => document.querySelector("pointreel-player").player.display?.following.seen, "the headset shows the scene");

for (const [mode, button] of [["VR", "Enter VR"], ["AR", "Enter AR"]]) {
  test(`${mode}: both eyes see the scene from their own places while it plays, and then the page is as before`, async () => {
    const { tab, close } = await open(emulated);
    const before = await ask(tab, "[player.player.canvas.width, player.player.canvas.height, player.player.camera.distance]");
    await tab.click(`button[aria-label="${button}"]`);
    await entered(tab);
    const shown = await tab.evaluate(async () => {
      const player = document.querySelector("pointreel-player");
      await player.play();
      return player.frame;
    });
    await until(tab, `document.querySelector("pointreel-player").frame > ${shown + 3}`, "frames advance");
    await ask(tab, "player.pause()");
    // The emulated eyes are 64 mm apart, so that what is 1 to 3 m away is a little further left for the right one.
    await until(tab, () => document.querySelector("pointreel-player").player.reel.shown?.look ===
      document.querySelector("pointreel-player").player.lookNumber, "the picture is that of the head's place");
    const [left, right] = await eyes(tab);
    console.log(`# left ${left.count} at ${left.column.toFixed(3)}, right ${right.count} at ${right.column.toFixed(3)}`);
    if (process.env.SHOTS) writeFileSync(join(process.env.SHOTS, `eyes-${mode}.png`), await tab.screenshot());
    assert.ok(left.count > 500 && right.count > 500);
    assert.ok(left.column - right.column > 0.005 && left.column - right.column < 0.2);
    await ask(tab, "player.player.display.leave()");
    await until(tab, () => !document.querySelector("pointreel-player").player.display, "the session is over");
    await settled(tab);
    assert.deepEqual(await ask(tab, "[player.player.canvas.width, player.player.canvas.height, player.player.camera.distance]"), before);
    await close();
  });
}

test("without a headset there are no buttons for one", async () => {
  const { tab, close } = await open("");
  assert.equal(await ask(tab, `[...root.querySelectorAll("button")].filter((b) => /^Enter/.test(b.title) && !b.hidden).length`), 0);
  await close();
});

test.after(async () => {
  await browser.close();
  server.close();
});
