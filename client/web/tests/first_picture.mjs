// node first_picture.mjs URL [ANGLE] [RUNS]: milliseconds from navigation to the first picture of the page at URL, with nothing in
// the cache of a browser that runs already. ANGLE: what draws, see browser.mjs. Prints the median of the RUNS (7) and all of them.
import { openBrowser } from "./browser.mjs";

const [url, angle = "swiftshader", runs = "7"] = process.argv.slice(2), browser = await openBrowser(angle), times = [];
for (let run = -1; run < Number(runs); ++run) {
  const context = await browser.newContext({ viewport: { width: 640, height: 360 } }), tab = await context.newPage();
  await tab.addInitScript(() => {
    window.shown = new Promise((resolve) => {
      document.addEventListener("firstpicture", () => resolve(performance.now()), true);
    });
  });
  await tab.goto(url);
  const ms = await tab.evaluate("window.shown");
  // The browser's own parts start with the first page.
  if (run >= 0) times.push(Math.round(ms));
  await context.close();
}
const sorted = [...times].sort((a, b) => a - b);
console.log(`median ${sorted[sorted.length >> 1]} ms of ${times.join(" ")}`);
await browser.close();
