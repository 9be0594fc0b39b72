// node screenshot.mjs FILE URL: a picture of the page as soon as it shows a frame, by the program CHROMIUM. Exits with 77 where
// there is no such program.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [file, url] = process.argv.slice(2), WAIT_MS = 30_000;
const profile = mkdtempSync(join(tmpdir(), "pointreel-page-"));
const browser = spawn(process.env.CHROMIUM || "chromium", [
  "--headless", "--remote-debugging-pipe", `--user-data-dir=${profile}`, "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader", "--hide-scrollbars", "--window-size=1280,720",
  ...(process.getuid() === 0 ? ["--no-sandbox"] : []),  // Chromium has none for root
], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });

// The Chrome DevTools Protocol on pipes: JSON texts with a zero after each.
const answers = new Map();
let text = "", last = 0;
for (const pipe of [3, 4]) browser.stdio[pipe].on("error", () => undefined);  // "exit" tells
browser.stdio[4].setEncoding("utf8").on("data", (part) => {
  const messages = (text + part).split("\0");
  text = messages.pop();
  for (const message of messages.map((m) => JSON.parse(m))) answers.get(message.id)?.(message);
});
const ask = (method, params, sessionId) => new Promise((resolve, reject) => {
  answers.set(++last, ({ error, result }) => (error ? reject(new Error(error.message)) : resolve(result)));
  browser.stdio[3].write(`${JSON.stringify({ id: last, method, params, sessionId })}\0`);
});

async function picture() {
  const { targetId } = await ask("Target.createTarget", { url });
  const { sessionId } = await ask("Target.attachToTarget", { targetId, flatten: true });
  const expression = `document.querySelector("pointreel-player")?.player.pictures > 0`;
  while (!(await ask("Runtime.evaluate", { expression }, sessionId)).result.value)
    await new Promise((resolve) => setTimeout(resolve, 100));
  // The first picture is a coarse one.
  await new Promise((resolve) => setTimeout(resolve, 2000));
  return (await ask("Page.captureScreenshot", {}, sessionId)).data;
}

const ends = new Promise((_, reject) => {
  browser.on("error", reject).on("exit", (code) => reject(new Error(`it ended with ${code}`)));
  setTimeout(() => reject(new Error(`the page showed nothing in ${WAIT_MS / 1000} s`)), WAIT_MS).unref();
});
try {
  writeFileSync(file, Buffer.from(await Promise.race([picture(), ends]), "base64"));
} catch (error) {
  const isMissing = error.code === "ENOENT" && error.syscall?.startsWith("spawn");
  console.error(isMissing ? "There is no Chromium, so there is no picture of the page: apt-get install chromium"
                          : `Chromium made no picture of the page: ${error.message}`);
  process.exitCode = isMissing ? 77 : 1;
}
// It ends when its pipes do. What was started may be a script, which would end alone by a signal.
browser.removeAllListeners("exit");
for (const pipe of [3, 4]) browser.stdio[pipe]?.destroy();
const patience = setTimeout(() => browser.kill(), 5000);
await new Promise((resolve) => (browser.exitCode === null && browser.pid ? browser.once("exit", resolve) : resolve()));
clearTimeout(patience);
rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });  // its processes end after it
