// node sound.mjs BUILD FOLDER: the sound of a reel in a browser. It stays with the page's clock, through seeks, loops
// and other speeds; it can be turned down and off; and the page says so where it cannot be heard.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync } from "node:fs";
import { basename, join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { serve } from "./serve.mjs";
import { ask, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2);
const page = join(build, "web"), reel = join(folder, "sounding"), wave = join(folder, "tone.wav");
cpSync(join(folder, "reel"), reel, { recursive: true });
execFileSync("ffmpeg", ["-v", "error", "-f", "lavfi", "-i", "sine=frequency=440:duration=3", wave]);
execFileSync(join(build, "bin/pointreel-server"), ["audio", reel, wave]);
const { server, port } = await serve(page, [reel, join(folder, "reel")]);
const browser = await openBrowser();
const open = (rest = "", options = {}, which = reel) =>
  openTab(browser, `http://127.0.0.1:${port}/${basename(which)}${rest}`, options);

const isTogether = () => {
  const { player } = document.querySelector("pointreel-player");
  return Math.abs(player.sound.ahead(player.reel.clock)) < 0.02;
};

test("sound begins with the user's first gesture and stays with the pictures", async () => {
  const { tab, close } = await open();
  await until(tab, () => document.querySelector("pointreel-player").frame > 3, "the reel plays");
  await tab.mouse.click(300, 100);
  await until(tab, isTogether, "sound is heard with its picture");
  for (const seconds of [2.2, 0.4, 1.7, 0.1]) {
    await ask(tab, `player.currentTime = ${seconds}`);
    await until(tab, isTogether, `after a seek to ${seconds} s`);
  }
  await ask(tab, "player.playbackRate = 0.5");
  await until(tab, isTogether, "at half the speed");
  await ask(tab, "player.playbackRate = -1");
  await until(tab, () => Number.isNaN(document.querySelector("pointreel-player").player.sound.ahead(
    document.querySelector("pointreel-player").player.reel.clock)), "silence backward");
  await ask(tab, "player.playbackRate = 1");
  await until(tab, isTogether, "forward again");
  await ask(tab, "player.pause()");
  await until(tab, () => document.querySelector("pointreel-player").player.sound.audio.paused, "silence in a pause");
  assert.equal(await ask(tab, "player.player.sound.problem"), null);
  await close();
});

test("keys and the button change the volume", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  await tab.keyboard.press("/");
  await tab.keyboard.press("/");
  await tab.keyboard.press("*");
  assert.equal((await ask(tab, "player.volume")).toFixed(2), "0.95");
  assert.equal((await ask(tab, "player.player.sound.audio.volume")).toFixed(2), "0.95");
  await tab.keyboard.press("M");
  assert.equal(await ask(tab, "player.muted"), true);
  await ask(tab, "root.querySelector('[title=\"Sound on\"]').click()");
  assert.equal(await ask(tab, "player.player.sound.audio.muted"), false);
  await close();
});

test("a browser that cannot play it says so in one line and shows pictures", async () => {
  const { tab, close } = await open("#t=0");
  await tab.addInitScript(() => { HTMLMediaElement.prototype.canPlayType = () => ""; });
  await tab.reload();
  await until(tab, () => document.querySelector("pointreel-player")?.frame === 0, "the reel is shown");
  assert.match(await ask(tab, "root.querySelector('[title^=\"this browser\"]').title"), /cannot play Opus in Ogg/);
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
});

test("a reel without sound has no button for it", async () => {
  const { tab, close } = await open("#t=0", {}, join(folder, "reel"));
  await settled(tab);
  assert.equal(await ask(tab, "root.querySelector('[title=\"Sound off\"]').hidden"), true);
  await close();
});

test.after(async () => {
  await browser.close();
  server.close();
});
