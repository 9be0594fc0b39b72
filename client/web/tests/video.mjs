// node video.mjs BUILD FOLDER: a reel of layered video in the page. It plays, seeks go to exact frames of any group, and where
// video cannot be decoded or is damaged, the octree below it is shown, with a line that says why.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { serve } from "./serve.mjs";
import { ask, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2), page = join(build, "web"), reel = join(folder, "video");
execFileSync(join(build, "bin/pointreel-server"),
             ["pack", "-i", join(folder, "clouds"), "-o", reel, "--clean", "off", "--codec", "video"], { stdio: "ignore" });
const { server, port } = await serve(page, [reel]);
const browser = await openBrowser();
const seek = async (tab, frame) => {
  await ask(tab, `player.currentTime = player.player.reel.reel.timesUs[${frame}] / 1e6`);
  await settled(tab);
  assert.equal(await ask(tab, "player.frame"), frame);
};
const layers = (tab) => ask(tab, "player.player.reel.shown.layers");

test("a reel of video plays, and a seek shows exactly that frame", async () => {
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${port}/video#t=0`);
  await settled(tab);
  const first = await ask(tab, "player.player.reel.shown.facts.points");
  // Into the middle of a group, its beginning, its end, and backward in one.
  for (const frame of [41, 16, 15, 47, 44, 0, 89]) {
    await seek(tab, frame);
    assert.equal(await layers(tab), 2);
    assert.ok(await ask(tab, "player.player.drawn") > 1000);
  }
  await seek(tab, 0);
  assert.equal(await ask(tab, "player.player.reel.shown.facts.points"), first);
  await ask(tab, "player.play()");
  await until(tab, () => {
    const { frame, player } = document.querySelector("pointreel-player");
    return frame > 20 && frame < 80 && player.reel.shown.layers === 2;
  }, "the reel plays beyond a group");
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
});

test("frames that only serve to decode others are not counted", async () => {
  const cut = join(folder, "cut");
  execFileSync(join(build, "bin/pointreel-server"), ["cut", reel, cut, "--frames", "6-9"], { stdio: "ignore" });
  const cutServer = await serve(page, [cut]);
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${cutServer.port}/cut#t=0`);
  await settled(tab);
  assert.equal(await ask(tab, "player.player.reel.reel.frames"), 10, "which begin with those of the group");
  assert.deepEqual(await ask(tab, "[player.frame, player.frames]"), [0, 4]);
  assert.match(await ask(tab, "root.querySelector('.frame').textContent"), /^frame 1 \/ 4/);
  await close();
  cutServer.server.close();
});

test("where pictures come too slowly frames are made coarser until it rests, or until there is time again", async () => {
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${port}/video#t=0`);
  await settled(tab);
  const asked = await ask(tab, "player.player.reel.shown.level");
  await ask(tab, "player.player.setLoop(true)");
  await ask(tab, "player.play()");
  /** As if the browser were ready for a picture so often. */
  const tick = (between, seconds) => tab.evaluate(([between, seconds]) => {
    const { pace } = document.querySelector("pointreel-player").player;
    delete pace.tick;
    pace.stepped = pace.last = 0;
    for (let now = 1e9; now < 1e9 + 1000 * seconds; now += between) pace.tick(now);
    pace.tick = () => undefined;
  }, [between, seconds]);
  await tick(100, 4);
  assert.equal(await ask(tab, "player.player.pace.coarsening(true).reduction"), 2);
  await until(tab, `document.querySelector("pointreel-player").player.reel.shown.level < ${asked}`, "frames are coarser");
  await ask(tab, "player.pause()");
  await settled(tab);
  assert.ok(await ask(tab, `player.player.reel.level === ${asked}`));
  await tick(16, 60);
  assert.equal(await ask(tab, "player.player.pace.coarsening(true).pixelSize"), 1);
  await close();
});

test("it plays backward", async () => {
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${port}/video#t=1`);
  await settled(tab);
  await ask(tab, "(player.playbackRate = -1, player.play())");
  await until(tab, () => {
    const { frame, player } = document.querySelector("pointreel-player");
    return frame < 14 && player.reel.shown.layers === 2;
  }, "the reel plays into the group before");
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
});

test("a decoder that takes seconds for each picture, as on a busy machine, is waited for", async () => {
  const slow = join(folder, "slow");
  cpSync(page, slow, { recursive: true });
  const [hash] = readdirSync(join(slow, "page")), worker = join(slow, "page", hash, "worker.js");
  writeFileSync(worker, `const SLOW_MS = 3000, Fast = self.VideoDecoder;
    self.VideoDecoder = class extends Fast {
      constructor(init) { super({ ...init, output: (frame) => setTimeout(() => init.output(frame), SLOW_MS) }); }
      flush() { return super.flush().then(() => new Promise((resolve) => setTimeout(resolve, SLOW_MS + 100))); }
    };\n` + readFileSync(worker, "utf8"));
  // Octrees are made before, in milliseconds, which is no measure for a decoder.
  const other = await serve(slow, [reel], [], { lateMs: (path) => (/\.video\./.test(path) ? 1000 : 0) });
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${other.port}/video#t=0`);
  await until(tab, () => document.querySelector("pointreel-player")?.player.reel?.shown, "the octree is shown");
  for (const frame of [0, 1, 18]) {
    await ask(tab, `player.currentTime = player.player.reel.reel.timesUs[${frame}] / 1e6`);
    await until(tab, new Function(`const { frame, player } = document.querySelector("pointreel-player");
                                   return frame === ${frame} && player.reel.shown?.layers === 2;`), `frame ${frame}`, 60_000);
    assert.equal(await ask(tab, "player.player.trouble"), null);
  }
  await close();
  other.server.close();
});

test("a damaged frame of video shows its octree, and says so", async () => {
  const other = await serve(page, [reel], [], { damage: (path, bytes) => {
    if (/\.video\./.test(path)) for (let i = 3000; i < Math.min(bytes.length, 3400); ++i) bytes[i] ^= 0x55;
    return bytes;
  } });
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${other.port}/video#t=0`);
  await until(tab, () => document.querySelector("pointreel-player")?.player.reel?.shown, "a picture is shown");
  await ask(tab, "player.currentTime = player.player.reel.reel.timesUs[12] / 1e6");
  await until(tab, () => /frame 12: /.test(document.querySelector("pointreel-player").player.trouble ?? ""), "the damage is named");
  await until(tab, () => document.querySelector("pointreel-player").player.reel.shown?.frame === 12, "the octree is shown");
  assert.equal(await layers(tab), 1);
  await close();
  other.server.close();
});

test("where the file of a segment's video is missing, its octrees play", async () => {
  const other = await serve(page, [reel], [], { damage: (path, bytes) => (/00000\.video\./.test(path) ? null : bytes) });
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${other.port}/video#t=0`, { requestsFail: true });
  await until(tab, () => document.querySelector("pointreel-player")?.player.reel?.shown, "a picture is shown");
  assert.match(await ask(tab, "player.player.trouble"), /video.*404|404.*video|not found/i);
  for (const frame of [5, 17]) {
    await seek(tab, frame);
    assert.equal(await layers(tab), 1);
  }
  await seek(tab, 60);
  assert.equal(await layers(tab), 2);
  await ask(tab, "(player.currentTime = 0, player.play())");
  await until(tab, () => document.querySelector("pointreel-player").frame > 50, "it plays beyond the segment");
  await close();
  other.server.close();
});

test("a page from plain http shows the octree, and says what helps", async () => {
  const plain = await openBrowser("gl-egl", ["--host-resolver-rules=MAP plain.test 127.0.0.1"]);
  const { tab, close } = await openTab(plain, `http://plain.test:${port}/video#t=0`);
  await settled(tab);
  assert.equal(await layers(tab), 1);
  assert.match(await ask(tab, "player.player.trouble"), /only a coarse picture: .*https:\/\/ or localhost/);
  await close();
  await plain.close();
});

test.after(async () => {
  await browser.close();
  server.close();
});
