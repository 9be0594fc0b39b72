// Debian's Chromium, without a window.
import { chromium } from "playwright-core";

/**
 * `angle`: what draws. "gl-egl" is the system's OpenGL, which the desktop player draws with, too. "swiftshader" is what
 * Chromium has without a graphics card; it takes a second more to compile the page's shaders. The two place points and
 * the edges of triangles with different precision. `more`: further arguments of Chromium.
 */
export const openBrowser = (angle = "gl-egl", more = []) => chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", `--use-angle=${angle}`, "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", ...more],
});

/** Waits until a question has the answer true. The page's policy forbids what Playwright has for this. */
export async function until(page, question, what, ms = 30_000) {
  const end = Date.now() + ms;
  while (!(await page.evaluate(question))) {
    if (Date.now() > end) throw new Error(`in vain: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/** Waits until a frame is shown as it should be, with all layers that the view needs. */
export const settled = (page) => until(page, () => {
  const player = document.querySelector("pointreel-player");
  const reel = player?.player.reel;
  if (player?.player.error) throw new Error(player.player.error);
  if (!reel?.shown || reel.isSeeking) return false;
  const { frame } = reel.clock.read(), { settings } = player.player;
  return reel.shown.frame === frame && reel.shown.layers >= reel.store.end(frame, reel.wanted) &&
    reel.isGood(reel.shown, { ...settings, scalar: player.player.scalar }, 1) && player.player.rested &&
    player.player.painted[0] === reel.shown && reel.shown.look === player.player.lookNumber;
}, "a frame settles");
