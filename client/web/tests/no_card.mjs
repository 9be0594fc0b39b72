// node no_card.mjs BUILD FOLDER: the page without a graphics card, where Chromium draws by SwiftShader.
import assert from "node:assert/strict";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { serve } from "./serve.mjs";
import { ask, countColors, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2);
const { server, port } = await serve(join(build, "web"), [join(folder, "reel")]);
const browser = await openBrowser("swiftshader");

test("each mode is drawn, and the page plays", async () => {
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${port}/reel#t=0`, { viewport: { width: 320, height: 180 } });
  for (const mode of ["surfel", "voxel", "point", "strip"]) {
    await ask(tab, `player.player.set({ mode: "${mode}" })`);
    await settled(tab);
    const colors = await countColors(tab);
    assert.ok(colors > 200, `${mode}: ${colors} colours`);
    assert.equal(await ask(tab, "player.player.reel.shown.mode"), mode);
  }
  await ask(tab, "player.play()");
  await until(tab, () => document.querySelector("pointreel-player").frame > 3, "the reel plays");
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
});

test.after(async () => {
  await browser.close();
  server.close();
});
