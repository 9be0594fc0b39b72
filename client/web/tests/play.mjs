// node play.mjs BUILD FOLDER: the page in a browser. It opens, plays, goes to exact frames, is dragged
// by mouse and by touch, loops, and fits on a narrow screen. Stray points do not spoil the first view.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { serve } from "./serve.mjs";
import { ask, countColors, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2);
const page = join(build, "web"), reel = join(folder, "reel");
const requests = [];
const { server, port } = await serve(page, [reel], requests);
const browser = await openBrowser();
const at = (rest, where = port) => `http://127.0.0.1:${where}/${basename(reel)}${rest}`;
const open = (rest, options = {}, where = port) => openTab(browser, at(rest, where), options);

test("the page plays, with few requests, and stays within what it may do", async () => {
  const { tab, close } = await open("");
  await until(tab, () => document.querySelector("pointreel-player").frame > 3, "the reel plays");
  const before = requests.length, seconds = 3;
  await tab.waitForTimeout(1000 * seconds);
  assert.ok((requests.length - before) / seconds <= 30);
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
});

/** A sphere around the origin, 2 across, and one point far away. */
function sphereWithStray() {
  const points = Array.from({ length: 20_000 }, (_, i) => {
    const z = 1 - (2 * i + 1) / 20_000, r = Math.sqrt(1 - z * z), turn = 2.399963 * i;
    return [r * Math.cos(turn), r * Math.sin(turn), z];
  });
  points.push([100, 0, 0]);
  return ["ply", "format ascii 1.0", `element vertex ${points.length}`, "property float x", "property float y",
          "property float z", "end_header", ...points.map((p) => p.join(" ")), ""].join("\n");
}

test("keys work where the address is not UTF-8", async () => {
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${port}/?reel=/${basename(reel)}/reel.json?%25e9#t=0`);
  await settled(tab);
  await tab.keyboard.press(".");
  await until(tab, () => document.querySelector("pointreel-player").frame === 1, "the next frame is shown");
  await close();
});

test("what is no address, or no token, is said", async () => {
  for (const [address, line] of [["/?reel=javascript:1", "javascript:1/reel.json: is not an address of http, https, ws or wss"],
                                 ["/?reel=http://[", "http://[/reel.json: is not an address of http, https, ws or wss"],
                                 [`/${basename(reel)}#token=a%00b`, "the server wants a valid token: this one has a blank or another character that no token may have"]]) {
    const { tab, close } = await openTab(browser, `http://127.0.0.1:${port}${address}`);
    await until(tab, `document.querySelector("pointreel-player").player.error === ${JSON.stringify(line)}`, line);
    await close();
  }
});

test("a stray point does not make the rest small in the first view", async () => {
  const clouds = join(folder, "stray_clouds"), stray = join(folder, "stray");
  mkdirSync(clouds);
  writeFileSync(join(clouds, "frame.ply"), sphereWithStray());
  execFileSync(join(build, "bin/pointreel-server"), ["pack", "-i", clouds, "-o", stray, "--clean", "off"]);
  const other = await serve(page, [stray]);
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${other.port}/stray#t=0`);
  await settled(tab);
  const near = await ask(tab, "[player.player.camera.distance, ...player.player.camera.state.slice(0, 3)]");
  assert.ok(near[0] < 10, `from ${near[0]} away`);
  assert.ok(Math.hypot(...near.slice(1)) < 0.5, `around ${near.slice(1)}`);
  await tab.keyboard.press("0");
  assert.ok(await ask(tab, "player.player.camera.distance") < 10);
  await close();
  other.server.close();
});

test("a seek shows exactly that frame", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  for (const frame of [5, 0, 7, 3]) {
    await ask(tab, `player.currentTime = player.player.reel.reel.timesUs[${frame}] / 1e6`);
    await settled(tab);
    assert.equal(await ask(tab, "player.frame"), frame);
  }
  await close();
});

test("another part behind # in the address is obeyed at once", async () => {
  const { tab, close } = await open("#t=0&mode=point");
  await settled(tab);
  await tab.keyboard.press("m");  // no attribute knows
  // The page may write the view that it shows before it hears of the new address.
  await ask(tab, `(
    location.hash = "#t=" + player.player.reel.reel.timesUs[5] / 1e6 + "&color=normals&view=0,1,0,3,0.5,0.25,2",
    history.replaceState(null, "", "#t=0"))`);
  await until(tab, "document.querySelector('pointreel-player').frame === 5", "the frame is shown");
  await settled(tab);
  const { mode, color } = await ask(tab, "player.player.settings");
  assert.deepEqual([mode, color], ["surfel", "normals"]);
  assert.ok(Math.abs(await ask(tab, "player.player.camera.yaw") - 0.5) < 1e-9);
  await close();
});

test("keys step, change the mode and the direction of view", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  await tab.keyboard.press(".");
  await settled(tab);
  assert.equal(await ask(tab, "player.frame"), 1);
  await tab.keyboard.press("m");
  await settled(tab);
  assert.equal(await ask(tab, "player.player.reel.shown.mode"), "voxel");
  await tab.keyboard.press("3");
  assert.ok(Math.abs(await ask(tab, "player.player.camera.yaw") + Math.PI / 2) < 1e-9);
  await close();
});

test("a drag of the mouse turns the scene, and one along the timeline goes to its frames", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  const yaw = await ask(tab, "player.player.camera.yaw");
  await tab.mouse.move(300, 150);
  await tab.mouse.down();
  await tab.mouse.move(360, 150, { steps: 3 });
  await tab.mouse.up();
  assert.ok(await ask(tab, "player.player.camera.yaw") < yaw - 0.1);
  const line = await tab.locator(".timeline").boundingBox();
  await tab.mouse.move(line.x + 2, line.y + line.height / 2);
  await tab.mouse.down();
  await tab.mouse.move(line.x + line.width / 2, line.y + line.height / 2, { steps: 5 });
  await tab.mouse.up();
  await settled(tab);
  const middle = await ask(tab, "player.player.reel.clock.frameAt(player.duration * 5e5)");
  assert.ok(Math.abs(await ask(tab, "player.frame") - middle) <= 1);
  await close();
});

test("a reel that loops begins anew, and one that does not ends", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  await ask(tab, "(player.currentTime = player.duration - 0.1, player.play())");
  await until(tab, () => {
    const player = document.querySelector("pointreel-player");
    return player.currentTime < player.duration / 2 && !player.paused;
  }, "the reel begins anew");
  await ask(tab, "(player.loop = false, player.currentTime = player.duration - 0.1)");
  await until(tab, () => document.querySelector("pointreel-player").ended, "the reel ends");
  assert.equal(await ask(tab, "player.paused"), true);
  await close();
});

test("one finger turns the scene and two zoom; everything fits on 320 pixels", async () => {
  const { tab, close } = await open("#t=0", { viewport: { width: 320, height: 568 }, hasTouch: true, isMobile: true });
  await settled(tab);
  const before = await ask(tab, "[player.player.camera.yaw, player.player.camera.distance]");
  const client = await tab.context().newCDPSession(tab);
  const touch = (type, ...points) => client.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  await touch("touchStart", [100, 200]);
  await touch("touchMove", [160, 200]);
  await touch("touchEnd");
  assert.ok(await ask(tab, "player.player.camera.yaw") < before[0] - 0.1);
  await touch("touchStart", [140, 200], [180, 200]);
  await touch("touchMove", [100, 200], [220, 200]);
  await touch("touchEnd");
  assert.ok(await ask(tab, "player.player.camera.distance") < 0.7 * before[1]);
  const outside = await ask(tab, `[...root.querySelectorAll("button, .timeline")].filter((e) => e.offsetParent)
    .filter((e) => { const b = e.getBoundingClientRect(); return b.left < 0 || b.right > innerWidth || b.bottom > innerHeight; }).length`);
  assert.equal(outside, 0);
  assert.equal(await tab.evaluate("document.documentElement.scrollWidth"), 320);
  const [left, middle, width] = await ask(tab, `(() => {
    const box = root.querySelector(".timeline").getBoundingClientRect();
    return [box.left, box.top + box.height / 2, box.width];
  })()`);
  await touch("touchStart", [left + 0.1 * width, middle]);
  for (const share of [0.3, 0.5]) await touch("touchMove", [left + share * width, middle]);
  await touch("touchEnd");
  await settled(tab);
  assert.ok(Math.abs(await ask(tab, "player.currentTime") - 1.5) < 0.1);
  await close();
});

/** The workers of a player. */
const hands = "[...player.player.content.pools.values()][0].hands";

test("a worker that does not answer any more is replaced, and its frames come from another", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  await ask(tab, `${hands}.forEach((hand) => { hand.worker.postMessage = () => undefined; })`);
  await ask(tab, "player.currentTime = 2");
  await until(tab, `(() => { const player = document.querySelector("pointreel-player"); return ${hands}.some((hand) => hand.life > 0); })()`, "a worker is replaced");
  await ask(tab, "player.currentTime = 2.5");
  await until(tab, "document.querySelector('pointreel-player').frame === 75", "the frame at 2.5 s");
  await close();
});

test("a worker that cannot be started is told of", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  await ask(tab, `${hands}[0].worker.onerror({ preventDefault() {} })`);
  await until(tab, "/cannot be started/.test(document.querySelector('pointreel-player').shadowRoot.querySelector('.trouble').textContent)", "the line");
  await close();
});

test("the loop button and the key change what the element's loop says", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  const before = await ask(tab, "player.loop");
  await tab.click("button[aria-label=Loop]");
  assert.deepEqual(await ask(tab, "[player.loop, player.player.loop]"), [!before, !before]);
  await tab.keyboard.press("Shift+L");
  assert.deepEqual(await ask(tab, "[player.loop, player.player.loop]"), [before, before]);
  await close();
});

test("a player that was taken out of the page and put back plays again", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  await tab.evaluate(async () => {
    window.player = document.querySelector("pointreel-player");
    window.place = player.parentNode;
    player.remove();
    await new Promise((resolve) => setTimeout(resolve, 500));
    place.append(player);
  });
  await settled(tab);
  const colors = await countColors(tab);
  assert.ok(colors > 200, `${colors} colours`);
  await close();
});

test("of a server without ranges, each file is fetched a few times only", async () => {
  const asked = [];
  const other = await serve(page, [reel], asked, { ranges: false });
  const { tab, close } = await open("", {}, other.port);
  await until(tab, () => document.querySelector("pointreel-player").frame > 20, "the reel plays");
  assert.equal(await ask(tab, "player.player.trouble"), null);
  const times = new Map();
  for (const { path, range } of asked) if (range) times.set(path, (times.get(path) ?? 0) + 1);
  // Those that were under way when the first came are fetched as well.
  for (const [path, count] of times) assert.ok(count <= 6, `${path}: ${count} requests`);
  await close();
  other.server.close();
});

test("what a server never answers is asked for again, and said", async () => {
  const asked = new Map();
  const silent = (path) => {
    const times = (asked.get(path) ?? 0) + 1;
    asked.set(path, times);
    return times === 1 && /reel\.json$|\.base\./.test(path);
  };
  const other = await serve(page, [reel], [], { silent });
  const { tab, close } = await open("#t=0", {}, other.port);
  await until(tab, () => /has sent nothing/.test(document.querySelector("pointreel-player")?.shadowRoot.querySelector(".trouble")?.textContent ?? ""), "the silence is said");
  await until(tab, () => document.querySelector("pointreel-player")?.player?.reel?.shown, "a picture is shown");
  await settled(tab);
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
  other.server.closeAllConnections();
  other.server.close();
});

test("every control has a name", async () => {
  const { tab, close } = await open("#t=0");
  await settled(tab);
  const nameless = await ask(tab, `[...root.querySelectorAll("button, input, [role=slider]")]
    .filter((e) => !(e.getAttribute("aria-label") || e.textContent.trim() || e.closest("label"))).length`);
  assert.equal(nameless, 0);
  await close();
});

test("damaged frames are named, and the others are shown", async () => {
  const damaged = (path, bytes) => {
    const copy = Buffer.from(bytes);
    for (let i = 20; i < copy.length; i += 97) copy[i] ^= 0x55;
    return copy;
  };
  let damages = true;
  const other = await serve(page, [reel], [], { damage: (path, bytes) => (damages ? damaged(path, bytes) : bytes) });
  const { tab, close } = await open("#t=0", {}, other.port);
  await until(tab, () => /^frame 0: /.test(document.querySelector("pointreel-player").player.trouble ?? ""), "the frame is named");
  damages = false;
  await ask(tab, "player.currentTime = player.player.reel.reel.timesUs[70] / 1e6");
  await settled(tab);
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
  other.server.close();
});

test.after(async () => {
  await browser.close();
  server.close();
});
