// node light_times.mjs URL [ANGLE] [ROUNDS] [SIZE]: milliseconds that a picture of the page at URL takes in flat light, in the
// light of a studio, and with contours, one after the other in each of the ROUNDS (15). ANGLE: what draws, see browser.mjs.
// Prints the median and the least of each.
import { openBrowser, settled } from "./browser.mjs";

const [url, angle = "swiftshader", rounds = "15", size = "1280x720"] = process.argv.slice(2);
const [width, height] = size.split("x").map(Number), browser = await openBrowser(angle);
const tab = await (await browser.newContext({ viewport: { width, height } })).newPage();
await tab.goto(url);
await settled(tab);
const times = await tab.evaluate(async (rounds) => {
  const { player } = document.querySelector("pointreel-player");
  const looks = { flat: { color: "colors", light: "flat" }, studio: { color: "colors", light: "studio" },
                  contours: { color: "contours", light: "flat" } };
  const times = Object.fromEntries(Object.keys(looks).map((name) => [name, []]));
  const { gl } = player.renderer, pixel = new Uint8Array(4);
  for (let round = -1; round < rounds; ++round) {
    for (const [name, look] of Object.entries(looks)) {
      Object.assign(player.settings, look);
      const start = performance.now();
      player.paint();
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);  // waits until it is drawn
      if (round >= 0) times[name].push(performance.now() - start);
    }
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  return times;
}, Number(rounds));
for (const [name, all] of Object.entries(times)) {
  const sorted = all.sort((a, b) => a - b);
  console.log(`${name}: median ${sorted[sorted.length >> 1].toFixed(1)} ms, least ${sorted[0].toFixed(1)} ms`);
}
await browser.close();
