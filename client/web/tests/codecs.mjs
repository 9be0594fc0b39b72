// node codecs.mjs BUILD FOLDER: reels of each codec play in the page, and seeks go to exact frames.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { serve } from "./serve.mjs";
import { ask, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2);
const OPTIONS = {
  context: ["--entropy", "context", "--slabs", "2"],
  zstd: ["--entropy", "zstd"],
  none: ["--entropy", "none"],
  draco: ["--codec", "draco", "--cl", "3"],
};
const reels = Object.fromEntries(Object.keys(OPTIONS).map((name) => [name, join(folder, name)]));
for (const [name, options] of Object.entries(OPTIONS)) {
  execFileSync(join(build, "bin/pointreel-server"),
               ["pack", "-i", join(folder, "clouds"), "-o", reels[name], "--clean", "off", ...options], { stdio: "ignore" });
}
const { server, port } = await serve(join(build, "web"), Object.values(reels));
const browser = await openBrowser();

for (const name of Object.keys(OPTIONS)) {
  test(`a reel of the codec ${name} plays, and a seek shows exactly that frame`, async () => {
    const { tab, close } = await openTab(browser, `http://127.0.0.1:${port}/${name}#t=0`);
    await settled(tab);
    for (const frame of [41, 3, 88]) {
      await ask(tab, `player.currentTime = player.player.reel.reel.timesUs[${frame}] / 1e6`);
      await settled(tab);
      assert.equal(await ask(tab, "player.frame"), frame);
      assert.ok(await ask(tab, "player.player.drawn") > 1000);
    }
    await ask(tab, "(player.currentTime = 0, player.play())");
    await until(tab, () => {
      const { frame } = document.querySelector("pointreel-player");
      return frame > 3 && frame < 80;
    }, "the reel plays");
    assert.equal(await ask(tab, "player.player.trouble"), null);
    await close();
  });
}

test.after(async () => {
  await browser.close();
  server.close();
});
