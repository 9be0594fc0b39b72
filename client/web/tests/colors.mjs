// node colors.mjs BUILD FOLDER: colours and light of the page, by its address, its attributes and its panel; legends, and what is
// said where there is nothing to show. pictures.mjs compares the pictures.
import assert from "node:assert/strict";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { packFields, writeEnvironment } from "./fields.mjs";
import { serve } from "./serve.mjs";
import { ask, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2), fields = packFields(build, folder);
writeEnvironment(fields);
const { server, port } = await serve(join(build, "web"), [fields]);
const browser = await openBrowser();
const open = (hash, options) => openTab(browser, `http://127.0.0.1:${port}/fields#t=0${hash}`, options);
const legend = (tab) => ask(tab, 'root.querySelector(".legend")?.getAttribute("aria-label") ?? null');

test("an address chooses a field and the ends of its ramp, and links to what is shown keep them", async () => {
  const { tab, close } = await open("&color=intensity&color-range=500,1500");
  await settled(tab);
  assert.equal(await legend(tab), "Legend of intensity: 500 to 1500");
  // The last layer holds the fields, and lies behind those of the geometry.
  assert.deepEqual(await ask(tab, "[player.player.reel.wanted.end, player.player.reel.shown.layers]"),
                   await ask(tab, "[player.player.reel.reel.layers, player.player.reel.reel.layers]"));
  await ask(tab, 'player.player.set({ light: "studio", roughness: 0.3 })');
  await until(tab, () => location.hash.includes("light=studio"), "the address follows");
  const { searchParams } = new URL(`http://here/?${(await tab.evaluate("location.hash")).slice(1)}`);
  assert.deepEqual(["color", "color-range", "light", "roughness"].map((name) => searchParams.get(name)),
                   ["intensity", "500,1500", "studio", "0.3"]);
  await close();
});

test("the panel offers the fields beside other colours, and light", async () => {
  const { tab, close } = await open("");
  await settled(tab);
  assert.equal(await legend(tab), null);
  await tab.keyboard.press("d");
  const select = tab.locator("pointreel-player select");
  assert.deepEqual(await select.locator("option").evaluateAll((all) => all.map(({ value }) => value)),
                   ["colors", "normals", "plain", "curvature", "accessibility", "depth", "contours", "intensity", "class"]);
  await select.selectOption("class");
  await settled(tab);
  assert.equal(await legend(tab), "Legend of class: 0, 1, 2, 3");
  await select.selectOption("intensity");
  await settled(tab);
  await tab.getByLabel("Largest value").fill("1000");
  await tab.keyboard.press("Enter");
  await settled(tab);
  assert.match(await legend(tab), /^Legend of intensity: \S+ to 1000$/);
  await select.selectOption("depth");
  await settled(tab);
  assert.equal(await legend(tab), null);
  const isShown = (name) => tab.getByLabel(name).isVisible();
  assert.deepEqual(await Promise.all(["Lighting", "Roughness"].map(isShown)), [true, false]);
  await tab.getByRole("radio", { name: "Studio" }).click();
  assert.deepEqual(await Promise.all(["Lighting", "Roughness"].map(isShown)), [false, true]);
  assert.equal(await tab.getByRole("radio", { name: "Environment" }).isVisible(), false);
  await close();
});

test("a saved picture has the legend", async () => {
  const { tab, close } = await open("");
  await settled(tab);
  const corner = () => tab.evaluate(async () => {
    const image = await createImageBitmap(await document.querySelector("pointreel-player").player.still());
    const canvas = new OffscreenCanvas(image.width, image.height), pen = canvas.getContext("2d");
    pen.drawImage(image, 0, 0);
    return [...pen.getImageData(16, image.height - 16, 1, 1).data].slice(0, 3);
  });
  const paper = [0x18, 0x1a, 0x1e];
  assert.notDeepEqual(await corner(), paper);
  await ask(tab, 'player.color = "intensity"');
  await settled(tab);
  assert.deepEqual(await corner(), paper);
  await close();
});

test("without such a field, or with no picture of light at an address, one line says so", async () => {
  const { tab, close } = await open("&color=height", { requestsFail: true });
  await settled(tab);
  assert.equal(await ask(tab, "root.querySelector('.trouble').textContent"),
               'there is no scalar field "height"; there are intensity, class');
  await ask(tab, 'player.color = ""');
  await ask(tab, 'player.environment = "/fields/nothing.hdr"');
  await until(tab, () => document.querySelector("pointreel-player").player.trouble, "that it is missing is said");
  assert.match(await ask(tab, "player.player.trouble"), /nothing\.hdr: the server answers 404/);
  await ask(tab, 'player.environment = "/fields/reel.json"');
  await until(tab, () => /reel\.json: /.test(document.querySelector("pointreel-player").player.trouble), "that it is none is said");
  assert.equal(await ask(tab, "player.player.light"), "flat");
  await ask(tab, 'player.environment = "/fields/evening.hdr"');
  await until(tab, () => document.querySelector("pointreel-player").player.light === "environment", "light comes");
  assert.equal(await ask(tab, "player.player.trouble"), null);
  await close();
});

test.after(async () => {
  await browser.close();
  server.close();
});
