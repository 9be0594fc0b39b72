// node playing_speed.mjs URL [ANGLE] [SECONDS] [SIZE]: how the page at URL plays in a loop, and jumps while it is paused: pictures a
// second, what it draws, and the milliseconds until an exact frame is shown after a jump. ANGLE: what draws, see browser.mjs.
import { openBrowser, settled, until } from "./browser.mjs";

const [url, angle = "gl-egl", seconds = "20", size = "640x360"] = process.argv.slice(2), JUMPS = 40;
const [width, height] = size.split("x").map(Number), browser = await openBrowser(angle);
const tab = await (await browser.newContext({ viewport: { width, height } })).newPage();
await tab.goto(url);
await until(tab, () => document.querySelector("pointreel-player")?.player.reel?.shown, "a picture");
await tab.evaluate(() => {
  const { player } = document.querySelector("pointreel-player");
  player.setLoop(true);
  player.play();
});
await new Promise((resolve) => setTimeout(resolve, 8000));  // until it has found its pace
const played = await tab.evaluate(async (seconds) => {
  const { player } = document.querySelector("pointreel-player"), { counts } = player.reel, first = counts.shown;
  const start = performance.now(), made = [];
  await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
  const spent = (performance.now() - start) / 1000;
  for (const { times } of player.reel.made.values()) made.push(times.prepareMs);
  return { rate: (counts.shown - first) / spent, ...player.coarsening, drawn: player.drawn, driver: player.renderer.driver,
           prepareMs: made.sort((a, b) => a - b)[made.length >> 1] };
}, Number(seconds));
console.log(`${played.driver}: ${played.rate.toFixed(1)} pictures a second at ${size}, ${played.drawn} elements, the least of ` +
            `${played.pixelSize} pixels, pictures 1/${played.reduction}; made ready in ${played.prepareMs.toFixed(0)} ms`);
await tab.evaluate(() => document.querySelector("pointreel-player").player.pause());
await settled(tab);
const jumps = await tab.evaluate(async (count) => {
  const { player } = document.querySelector("pointreel-player"), times = [], { frames, timesUs } = player.reel.reel;
  for (let i = 0; i < count; ++i) {
    const frame = (i * 7919 + 5) % frames, start = performance.now();
    player.reel.seek(timesUs[frame]);
    player.schedule();
    while (player.reel.isSeeking) await new Promise((resolve) => setTimeout(resolve, 1));
    times.push(performance.now() - start);
    await new Promise((resolve) => setTimeout(resolve, 1000));  // as long as nobody does anything, pictures become finer
  }
  return times.sort((a, b) => a - b);
}, JUMPS);
console.log(`jumps: median ${jumps[JUMPS >> 1].toFixed(0)} ms, 95 % within ${jumps[Math.floor(0.95 * JUMPS)].toFixed(0)} ms`);
await browser.close();
