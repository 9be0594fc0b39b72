// node live.mjs BUILD FOLDER: live streams in the page, from servers that want tokens.
import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, until } from "./browser.mjs";
import { programs } from "./programs.mjs";
import { ask, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2);
const { serve, publish, link } = programs(build);
const WAIT = 60_000;
const browser = await openBrowser();
const open = (url) => openTab(browser, url, { requestsFail: true });

/** `grace`: for how many seconds a name belongs to a publisher that has gone. */
const serveLive = (listen = "127.0.0.1:0") => serve(
  "--live", "--listen", listen, "--view-token", "see", "--publish-token", "send", "--publisher-grace", "0");
const clouds = join(folder, "clouds");
const publishTo = (address, name, input = clouds) => publish(
  "-i", input, "--loop", "--fps", "10", "--depth", "7", "--to", `ws://${address}/live/${name}`, "--token", "send");

/** Waits until each stream shows a frame, and then `count` frames more. */
async function moves(tab, count = 3) {
  await until(tab, () => {
    const { live } = document.querySelector("pointreel-player").player;
    return live.length > 0 && live.every((one) => one.shown);
  }, "each stream shows a frame", WAIT);
  const before = await ask(tab, "player.player.live.map((live) => live.frames)");
  await until(tab, `document.querySelector("pointreel-player").player.live.every(
    (live, i) => live.frames >= ${JSON.stringify(before)}[i] + ${count})`, "the streams move", WAIT);
}
const says = (tab, text) => until(tab, `(document.querySelector("pointreel-player").player.trouble ?? "").includes(
  ${JSON.stringify(text)})`, `the page says "${text}"`, WAIT);

test("two publishers stand beside each other in one scene", async () => {
  const server = await serveLive();
  // One cloud again and again: the two need not show the same moment.
  const still = join(clouds, readdirSync(clouds).sort()[0]);
  const publishers = ["alice", "bob"].map((name) => publishTo(server.address, name, still));
  const { tab, close } = await open(`http://${server.address}/?live=alice,bob&at=-0.6,0,0;0.6,0,0#token=see`);
  await moves(tab);
  assert.equal(await ask(tab, "player.player.trouble"), null);
  assert.equal(await ask(tab, "player.paused"), false);
  const [left, right] = await ask(tab, "player.player.live.map((live) => live.bounds.min[0])");
  assert.ok(Math.abs(right - left - 1.2) < 1e-3, `${left} and ${right}`);
  if (process.env.KEEP) await tab.screenshot({ path: join(process.env.KEEP, "two.png") });
  await close();
  for (const program of [...publishers, server]) await program.end();
});

test("a stream that is paused follows the choice of a mode", async () => {
  const server = await serveLive(), publisher = publishTo(server.address, "alice");
  const { tab, close } = await open(`http://${server.address}/live/alice#token=see`);
  await moves(tab);
  await ask(tab, "player.pause()");
  // The frame that was being made may still come.
  await until(tab, `!document.querySelector("pointreel-player").player.live[0].busy`, "no frame is being made", WAIT);
  const frame = await ask(tab, "player.player.live[0].shown.frame");
  await ask(tab, 'void (player.mode = "voxel")');
  await until(tab, `document.querySelector("pointreel-player").player.live[0].shown.mode === "voxel"`, "voxels are shown", WAIT);
  assert.equal(await ask(tab, "player.player.live[0].shown.frame"), frame);
  await close();
  for (const program of [publisher, server]) await program.end();
});

test("a page says that its server allows no connection to others", async () => {
  const server = await serveLive();
  const { tab, close } = await open(`http://${server.address}/?live=ws://127.0.0.2:9/live/alice#token=see`);
  await says(tab, "ws://127.0.0.2:9/live/alice: the security policy of this page does not allow connections to this server");
  await close();
  await server.end();
});

test("a link that names very many streams opens some of them and says so", async () => {
  const server = await serveLive(), names = Array.from({ length: 200 }, (_, i) => `s${i}`);
  const { tab, close } = await open(`http://${server.address}/?live=${names.join(",")}#token=see`);
  await until(tab, `document.querySelector("pointreel-player").player.isOpen`, "it is open", WAIT);
  assert.equal(await ask(tab, "player.player.live.length"), 16);
  await says(tab, "only the first 16 of 200 live streams are shown");
  await close();
  await server.end();
});

test("without the right token, one line says what to do", async () => {
  const server = await serveLive();
  const publisher = publishTo(server.address, "alice");
  for (const token of ["", "#token=wrong", "#token=a%00b"]) {
    const { tab, close } = await open(`http://${server.address}/live/alice${token}`);
    await says(tab, "valid token");
    await until(tab, `document.querySelector("pointreel-player").shadowRoot.textContent.includes("valid token")`,
                "a person sees it");
    await tab.fill(".token input", " see ");
    await Promise.all([tab.waitForEvent("load"), tab.keyboard.press("Enter")]);
    await moves(tab);
    await close();
  }
  for (const program of [publisher, server]) await program.end();
});

test("the page is back by itself after the server was restarted", async () => {
  const server = await serveLive();
  const publisher = publishTo(server.address, "alice");
  const { tab, close } = await open(`http://${server.address}/live/alice#token=see`);
  await moves(tab);
  await server.end("SIGKILL");
  await says(tab, "lost");
  assert.ok(await ask(tab, "player.player.pictures") > 0);
  const again = await serveLive(server.address);
  await moves(tab);
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
  for (const program of [publisher, again]) await program.end();
});

test("frames keep coming over a slow link, without trouble", async () => {
  const server = await serveLive();
  const publisher = publishTo(server.address, "alice");
  const slow = await link("--to", server.address, "--rate", "2M", "--delay", "20");
  const { tab, close } = await open(`http://${slow.address}/live/alice#token=see`);
  await moves(tab, 10);
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
  for (const program of [publisher, slow, server]) await program.end();
});

test("the last picture of a publisher that has gone stays, until there is another one", async () => {
  const server = await serveLive();
  const publisher = publishTo(server.address, "alice");
  const { tab, close } = await open(`http://${server.address}/live/alice#token=see`);
  await moves(tab);
  await publisher.end();
  await says(tab, "the publisher has gone");
  assert.ok(await ask(tab, "player.player.drawn") > 0);
  const next = publishTo(server.address, "alice");
  await moves(tab);
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
  for (const program of [next, server]) await program.end();
});

test.after(async () => {
  await browser.close();
});
