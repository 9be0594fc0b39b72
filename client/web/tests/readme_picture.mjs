// node readme_picture.mjs PAGE REEL OUT.png: the page with its statistics, and the mouse on the
// timeline.
import { basename } from "node:path";
import { openBrowser, settled } from "./browser.mjs";
import { serve } from "./serve.mjs";

const [page, reel, out] = process.argv.slice(2);
const { server, port } = await serve(page, [reel]);
const browser = await openBrowser("gl-egl");
const tab = await (await browser.newContext({ viewport: { width: 1000, height: 563 } })).newPage();
await tab.goto(`http://127.0.0.1:${port}/${basename(reel)}#t=1.1`);
await settled(tab);
await tab.mouse.move(500, 300);
await tab.mouse.down();
await tab.mouse.move(430, 310, { steps: 8 });
await tab.mouse.up();
await tab.keyboard.press("i");
await tab.waitForTimeout(3000);
await settled(tab);
await tab.mouse.move(620, 505);
await tab.waitForTimeout(500);
await tab.screenshot({ path: out });
await browser.close();
server.close();
