// One page of a browser with a player in it.
import assert from "node:assert/strict";

/**
 * Opens an address. `close()` fails if the page has thrown or an error was logged. Chromium logs each
 * failed request; with `requestsFail`, the test asks what the page makes of those.
 */
export async function openTab(browser, url, { requestsFail = false, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 640, height: 360 }, ...options });
  const tab = await context.newPage();
  const faults = [];
  tab.on("pageerror", (error) => faults.push(error.message));
  tab.on("console", (message) => {
    const isRequest = requestsFail && /^Failed to load resource|^WebSocket connection to|^Access to fetch at|^Connecting to/.test(message.text());
    if (message.type() === "error" && !isRequest) faults.push(message.text());
  });
  await tab.goto(url);
  return { tab, close: async () => {
    assert.deepEqual(faults, []);
    await context.close();
  } };
}

/** How many colours the player's picture has. */
export const countColors = (tab) => tab.evaluate(async () => {
  const picture = await createImageBitmap(await document.querySelector("pointreel-player").player.still());
  const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
  context.drawImage(picture, 0, 0);
  return new Set(new Uint32Array(context.getImageData(0, 0, picture.width, picture.height).data.buffer)).size;
});

/** Evaluates an expression of `player`, the element, and `root`, what is inside of it. */
export const ask = (tab, question) => tab.evaluate(`(() => {
  const player = document.querySelector("pointreel-player"), root = player.shadowRoot; return ${question};
})()`);
