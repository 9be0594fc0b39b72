// node package.mjs TARBALL SERVER REEL (of 90 frames at 30 a second): the npm package, installed and served by a
// server of plain files. The reel comes from SERVER, on another origin. The element does what <video> does.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { test } from "node:test";
import { openBrowser, until } from "./browser.mjs";
import { serveFiles, serveReels } from "./origins.mjs";
import { installPackage } from "./package_site.mjs";
import { openTab } from "./tab.mjs";

const installed = await installPackage(...process.argv.slice(2));
const { folder, site, server } = installed;
writeFileSync(join(folder, "empty.html"), "<!doctype html>");
const library = await serveFiles(folder);
const browser = await openBrowser();
const open = (path, options = {}) => openTab(browser, site.origin + path, options);

const noted = ["emptied", "loadstart", "durationchange", "loadedmetadata", "loadeddata", "canplay", "play", "playing", "pause",
               "seeking", "seeked", "ended", "error"];

/** A page with one player, whose events are kept. */
async function openOne(origin = site.origin, options = {}) {
  const { tab, close } = await open("/empty.html", options);
  await tab.evaluate(async ([script, noted, src]) => {
    await import(script);
    window.player = document.createElement("pointreel-player");
    window.events = [];
    for (const name of noted) player.addEventListener(name, () => events.push(name));
    document.body.append(player);
    window.src = src;
  }, [`${origin}/node_modules/pointreel-player/player/element.js`, noted, `${server.origin}/walk`]);
  return { tab, close };
}

test("two players in a page play reels of another server", async () => {
  const { tab, close } = await open("/two.html");
  const frames = "[...document.querySelectorAll('pointreel-player')].map((player) => player.frame)";
  await until(tab, `${frames}[0] > 3`, "the first plays by itself");
  await until(tab, `${frames}[1] >= 0`, "the second shows its first frame");
  assert.equal(await tab.evaluate("document.querySelectorAll('pointreel-player')[1].paused"), true);
  await tab.click("#together");
  await until(tab, `${frames}[0] > 3 && ${frames}[1] > 3`, "both play");
  await until(tab, "/^[0-9.]+ of 3.0 s, [0-9.]+ of 3.0 s$/.test(document.querySelector('#times').textContent)", "the times are shown");
  await close();
});

test("the element may come from a server that is not the page's", async () => {
  const { tab, close } = await openOne(library.origin);
  await tab.evaluate("(player.autoplay = true, player.src = src)");
  await until(tab, "player.frame > 3", "the reel plays");
  await close();
});

test("as of <video>: events come in order, and properties tell the state", async () => {
  const { tab, close } = await openOne();
  assert.deepEqual(await tab.evaluate("[player.readyState, player.paused, player.duration, player.buffered.length, player.error]"),
                   [0, true, NaN, 0, null]);
  await tab.evaluate("player.src = src");
  await until(tab, "events.includes('canplay')", "a frame is there");
  assert.deepEqual(await tab.evaluate("events"), ["loadstart", "durationchange", "loadedmetadata", "loadeddata", "canplay"]);
  assert.deepEqual(await tab.evaluate("[player.paused, player.duration, player.seekable.end(0), player.currentTime, player.frame]"),
                   [true, 3, 3, 0, 0]);
  await until(tab, "player.buffered.length > 0 && player.buffered.start(0) === 0 && player.buffered.end(0) > 0.5", "frames are buffered");
  assert.equal(await tab.evaluate("events.splice(0), player.play().then(() => [player.paused, events.join()].join(' '))"), "false play,playing");
  assert.equal(await tab.evaluate("events.splice(0), player.pause(), player.pause(), events.join()"), "pause");
  await tab.evaluate("events.splice(0), player.currentTime = '99'");  // as the value of a slider is
  await until(tab, "events.includes('seeked')", "the end is shown");
  assert.deepEqual(await tab.evaluate("[events.join(), player.currentTime.toFixed(3)]"), ["seeking,seeked", "3.000"]);
  await close();
});

test("as of <video>: at the end it is paused and ended, and plays from the beginning again", async () => {
  const { tab, close } = await openOne();
  await tab.evaluate("player.currentTime = 2.8, player.src = src");
  await tab.evaluate("player.play()");
  await until(tab, "player.ended", "the end");
  assert.deepEqual(await tab.evaluate("[player.paused, events.slice(-2).join()]"), [true, "pause,ended"]);
  await tab.evaluate("player.play()");
  assert.ok(await tab.evaluate("!player.ended && player.currentTime < 2"));
  await close();
});

test("as of <video>: play() waits for the source, and is rejected if it is stopped or fails", async () => {
  const { tab, close } = await openOne();
  const outcome = "then(() => 'plays', (error) => error.name)";
  assert.equal(await tab.evaluate(`(() => { const played = player.play(); player.src = src; return played.${outcome}; })()`), "plays");
  assert.equal(await tab.evaluate("player.paused"), false);
  assert.equal(await tab.evaluate(`(() => { player.load(); const played = player.play(); player.pause(); return played.${outcome}; })()`), "AbortError");
  assert.equal(await tab.evaluate("(() => { try { player.currentTime = NaN; } catch (error) { return error.name; } })()"), "TypeError");
  await close();
});

test("as of <video>: the poster stands until a frame is there, and moving the element changes nothing", async () => {
  const { tab, close } = await openOne();
  await tab.evaluate("player.poster = 'data:image/gif;base64,R0lGODlhAQABAAAAACw='");
  assert.equal(await tab.evaluate("player.shadowRoot.querySelectorAll('img').length"), 1);
  await tab.evaluate("player.currentTime = 1, player.src = src");
  await until(tab, "player.readyState >= 2", "a frame is there");
  assert.equal(await tab.evaluate("player.shadowRoot.querySelectorAll('img').length"), 0);
  await tab.evaluate("(events.splice(0), document.body.prepend(player))");
  assert.deepEqual(await tab.evaluate("[player.frame, events.join()]"), [30, ""]);
  await close();
});

test("attributes say from where a reel is seen, and on what", async () => {
  const { tab, close } = await openOne();
  await tab.evaluate("Object.assign(player, { view: '90,10', up: '-y', background: '#ff0000', floor: true, src })");
  await until(tab, "player.readyState >= 2", "a frame is there");
  const state = () => tab.evaluate(`[Math.round(player.player.camera.yaw * 180 / Math.PI), player.player.camera.up,
                                     player.player.settings.background.join(), player.player.settings.floor].join(" ")`);
  assert.equal(await state(), "90 -2 1,0,0 true");
  await tab.evaluate("Object.assign(player, { view: 'back', up: '', background: 'no colour', floor: false })");
  assert.match(await state(), /^-?180 2 0\.1\S* false$/);
  await close();
});

test("a server that does not let the page read a reel is named", async (t) => {
  const refusing = await serveReels(process.argv[3], [process.argv[4]], "https://elsewhere.example");
  t.after(() => refusing.close());
  const { tab, close } = await openOne(site.origin, { requestsFail: true });
  await tab.evaluate(`player.src = ${JSON.stringify(`${refusing.origin}/${basename(process.argv[4])}`)}`);
  await until(tab, "player.error", "it fails");
  assert.match(await tab.evaluate("player.error.message"), /does not let this page read; .* --allow-origin http:/);
  await close();
});

test("programs in TypeScript know its interface", () => {
  writeFileSync(join(folder, "use.mts"), `import type { PointreelPlayer } from "pointreel-player";
    const player: PointreelPlayer = document.querySelector("pointreel-player")!;
    player.addEventListener("firstpicture", () => console.log(player.frame, player.buffered.length));
    player.play().then(() => { player.currentTime += 1; });
    player.volume = 0.5;
    // @ts-expect-error
    player.preservesPitch = true;`);
  execFileSync("tsc", ["--noEmit", "--strict", "--target", "es2021", "--moduleResolution", "node16", "--module", "node16", "use.mts"],
               { cwd: folder, stdio: ["ignore", "inherit", "inherit"] });
});

test.after(async () => {
  await browser.close();
  library.close();
  installed.close();
});
