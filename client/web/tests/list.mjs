// node list.mjs BUILD FOLDER: the list of a server with many reels.
import assert from "node:assert/strict";
import { symlinkSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, until } from "./browser.mjs";
import { serve } from "./serve.mjs";
import { openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2), REELS = 50;
const reels = Array.from({ length: REELS }, (_, i) => join(folder, `reel${i}`));
for (const reel of reels) symlinkSync(join(folder, "reel"), reel);
const requests = [];
const { server, port } = await serve(join(build, "web"), reels, requests);
const files = await serve(join(build, "web"), reels.slice(0, 2), [], {
  plain: true, others: [null, { name: "foreign", url: "https://elsewhere.example/a", manifest: "https://elsewhere.example/a/reel.json" }],
});
const browser = await openBrowser();

test("reels on the screen get their pictures one by one, and the others when one scrolls to them", async () => {
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${port}/`);
  await until(tab, () => document.querySelectorAll(".picture img").length >= 3, "three pictures", 60_000);
  assert.equal(await tab.evaluate(`document.querySelectorAll(".cards a").length`), REELS);
  assert.ok(await tab.evaluate(`document.querySelectorAll("pointreel-player").length`) <= 1);
  const last = reels.length - 1, asked = () => requests.some(({ path }) => path === `/reel${last}/reel.json`);
  assert.ok(!asked());
  await tab.evaluate(() => document.querySelector(".cards li:last-child").scrollIntoView());
  await until(tab, () => document.querySelector(".cards li:last-child img")?.naturalWidth > 0, "the last picture", 60_000);
  const shown = () => tab.evaluate(`[...document.querySelectorAll(".cards li")].filter((card) => !card.hidden).length`);
  const search = (text) => tab.evaluate(`(() => {
    const field = document.querySelector("input[type=search]");
    field.value = ${JSON.stringify(text)};
    field.dispatchEvent(new Event("input"));
  })()`);
  await search("REEL4 2026-01");
  assert.equal(await shown(), 10, "reel4 and reel40 to reel49, but not reel47");
  await search("2025-07-01");
  assert.equal(await shown(), 5, "those that were captured that day: reel7, reel17 and so on");
  await search("nothing of the kind");
  assert.equal(await shown(), 0);
  await search("");
  assert.equal(await shown(), REELS);
  if (process.env.KEEP) await tab.screenshot({ path: join(process.env.KEEP, "list.png") });
  await close();
});

test("where a server serves files and nothing else, the list is reels.json, and there is a way back to it", async () => {
  const { tab, close } = await openTab(browser, `http://127.0.0.1:${files.port}/`);
  await until(tab, () => document.querySelectorAll(".cards a").length === 2, "two reels");
  assert.deepEqual(await tab.evaluate(() => [...document.querySelectorAll(".fault")].map((line) => line.textContent)),
                   ["A reel without a name is left out: its entry makes no sense",
                    "foreign is left out: it names an address elsewhere, https://elsewhere.example"]);
  assert.equal(await tab.evaluate(`document.querySelector(".cards a").getAttribute("href").replace(/^.*\\/index/, "index")`),
               "index.html?reel=reel0%2Freel.json");
  await tab.goto(await tab.evaluate(() => document.querySelector(".cards a").href));
  await until(tab, () => document.querySelector("pointreel-player")?.player.pictures > 0, "a picture", 60_000);
  const back = () => tab.evaluate(`getComputedStyle(document.querySelector(".way-back")).opacity`);
  assert.equal(await back(), "0");
  await tab.evaluate(() => window.dispatchEvent(new PointerEvent("pointermove")));
  await until(tab, () => getComputedStyle(document.querySelector(".way-back")).opacity === "1", "the link");
  await tab.goto(await tab.evaluate(() => document.querySelector(".way-back").href));
  await until(tab, () => document.querySelectorAll(".cards a").length === 2, "the list again");
  await close();
});

test.after(async () => {
  await browser.close();
  server.close();
  files.server.close();
});
