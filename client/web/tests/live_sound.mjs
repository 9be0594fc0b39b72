// node live_sound.mjs BUILD FOLDER: the sound of a live stream in the page. A sphere flashes each second, and with it
// there is a click in a tone: both come together, at first, after the link has stalled, and after the server was started
// again. Muted pages are sent no sound, and what is damaged is one line. WITHIN=20 lowers the limit from 200 to 20 ms, for a
// machine that does nothing else.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, until } from "./browser.mjs";
import { programs } from "./programs.mjs";
import { ask, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2);
const { serve, publish, link } = programs(build);
const WAIT = Number(process.env.WAIT ?? 60_000), FPS = 25, SECONDS = 4, FLASH = 12;  // frames
const WITHIN = Number(process.env.WITHIN ?? 200);  // ms
const clouds = join(folder, "flashing"), wave = join(folder, "clicking.wav");

function sphere(gray) {
  const points = Array.from({ length: 1500 }, (_, i) => {
    const z = 1 - (2 * i + 1) / 1500, r = Math.sqrt(1 - z * z), turn = 2.399963 * i;
    return `${r * Math.cos(turn)} ${r * Math.sin(turn)} ${z} ${gray} ${gray} ${gray}`;
  });
  return ["ply", "format ascii 1.0", `element vertex ${points.length}`, "property float x", "property float y", "property float z",
          "property uchar red", "property uchar green", "property uchar blue", "end_header", ...points, ""].join("\n");
}
mkdirSync(clouds);
for (let i = 0; i < FPS * SECONDS; ++i)
  writeFileSync(join(clouds, `frame${String(i).padStart(4, "0")}.ply`), sphere(i % FPS < FLASH ? 255 : 20));
execFileSync("ffmpeg", ["-v", "error", "-f", "lavfi", "-i",
  `aevalsrc='if(lt(mod(t,1),0.005),0.8*sin(2*PI*2000*t),0.05*sin(2*PI*440*t))':d=${SECONDS}:s=48000`, wave]);

const serveLive = (listen = "127.0.0.1:0") => serve("--live", "--listen", listen, "--publisher-grace", "0");
const publishTo = (address, audio = ["--audio", wave]) => publish(
  "-i", clouds, "--loop", "--fps", String(FPS), "--depth", "6", ...audio, "--to", `ws://${address}/live/alice`);
const browser = await openBrowser();
/** The policy of the page forbids what listens here. Small pictures are drawn fast, also where nothing but software draws. */
const open = (address) => openTab(browser, `http://${address}/live/alice`,
  { requestsFail: true, bypassCSP: true, viewport: { width: 240, height: 160 } });
const moves = (tab) => until(tab, () => document.querySelector("pointreel-player")?.player?.live[0]?.frames > 5, "the stream moves", WAIT);
const trouble = (tab) => ask(tab, "player.player.trouble");

/**
 * Notes when clicks are heard and when flashes are seen, in Unix milliseconds: of the first frame of a flash, if that was left
 * out, when it would have been.
 */
async function watch(tab) {
  await moves(tab);
  await tab.mouse.click(200, 40);
  await until(tab, () => !Number.isNaN(document.querySelector("pointreel-player").player.live[0].sound.delayMs), "sound is heard", WAIT);
  await tab.evaluate(async () => {
    const { player } = document.querySelector("pointreel-player"), { paint, renderer: { gl } } = player;
    const noted = window.noted = { clicks: [], flashes: [] }, pixel = new Uint8Array(4);
    let wasBright = true;
    player.paint = () => {
      paint.call(player);
      const bound = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
      gl.readPixels(gl.drawingBufferWidth / 2, gl.drawingBufferHeight / 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, bound);
      const isBright = pixel[0] > 128, isFlash = isBright && !wasBright;
      const { shownAt, sound: { last } } = player.live[0];
      wasBright = isBright;
      if (!last) return;  // before the first sound of another session
      const begin = last.captureMs - 20 * last.number;  // of the file of sound
      // It is seen when the next picture could be drawn.
      if (isFlash) requestAnimationFrame(() => noted.flashes.push(performance.timeOrigin + performance.now() - (shownAt.capture - begin) % 1000));
    };
    const script = `registerProcessor("clicks", class extends AudioWorkletProcessor {
      quiet = 0;
      process([[samples]]) {
        for (let i = 0; i < (samples ? samples.length : 0); ++i) {
          const isLoud = Math.abs(samples[i]) > 0.3;
          if (isLoud && this.quiet > 9600) this.port.postMessage((currentFrame + i) / sampleRate);
          this.quiet = isLoud ? 0 : this.quiet + 1;
        }
        return true;
      }
    })`;
    const { context, gain } = player.content.liveSounds.output.sink;
    await context.audioWorklet.addModule(URL.createObjectURL(new Blob([script], { type: "text/javascript" })));
    const clicks = new AudioWorkletNode(context, "clicks");
    gain.connect(clicks);
    clicks.port.onmessage = ({ data }) => {
      const { contextTime, performanceTime } = context.getOutputTimestamp();
      noted.clicks.push(performance.timeOrigin + performanceTime + 1000 * (data - contextTime));
    };
  });
}
/** Waits until clicks and flashes come together: of those from now on, the newest five. */
async function areTogether(tab, t, when) {
  const from = Date.now(), end = from + WAIT;
  for (;;) {
    const { clicks, flashes } = await tab.evaluate("window.noted");
    const ahead = flashes.filter((flash) => flash > from).flatMap((flash) => {
      const off = clicks.map((click) => flash - click).filter((ms) => Math.abs(ms) < 450);
      return off.length ? [off.reduce((a, b) => (Math.abs(a) < Math.abs(b) ? a : b))] : [];
    }).slice(-5);
    const median = [...ahead].sort((a, b) => a - b)[2];
    const text = `${when}, sound is ahead of the picture by ${ahead.map((ms) => ms.toFixed(1)).join(", ")} ms`;
    if (Math.abs(median) < WITHIN) return t.diagnostic(text);
    if (Date.now() > end) throw new Error(text + `, with ${clicks.length} clicks and ${flashes.length} flashes`);
    await new Promise((resolve) => setTimeout(resolve, 250));
  }
}

test("sound is heard with its pictures, also after the link has stalled", async (t) => {
  const server = await serveLive(), publisher = publishTo(server.address);
  const script = join(folder, "stall");
  writeFileSync(script, "25 cut\n28 restore\n");
  const stalling = await link("--to", server.address, "--script", script);
  const { tab, close } = await open(stalling.address);
  await watch(tab);
  await areTogether(tab, t, "at first");
  assert.equal(await trouble(tab), null);
  const player = `document.querySelector("pointreel-player").player`;
  await until(tab, `performance.now() - ${player}.live[0].sound.came > 1500`, "the link stalls", WAIT);
  await until(tab, `performance.now() - ${player}.live[0].sound.came < 100`, "it passes on again", WAIT);
  await areTogether(tab, t, "after a stall");
  if (process.env.KEEP) await tab.screenshot({ path: join(process.env.KEEP, "live_sound.png") });
  await close();
  for (const program of [publisher, stalling, server]) await program.end();
});

test("sound comes back with the pictures after the server was started again", async (t) => {
  const server = await serveLive(), publisher = publishTo(server.address);
  const { tab, close } = await open(server.address);
  await watch(tab);
  await server.end("SIGKILL");
  await until(tab, `document.querySelector("pointreel-player").player.trouble?.includes("lost")`, "the page says it", WAIT);
  const again = await serveLive(server.address);
  await until(tab, () => document.querySelector("pointreel-player").player.trouble === null, "it is back", WAIT)
    .catch(async (error) => { throw new Error(`${error.message}: ${await trouble(tab)}`); });
  await areTogether(tab, t, "after a new start");
  await close();
  for (const program of [publisher, again]) await program.end();
});

test("a browser without WebCodecs, as all are without HTTPS, hears the same", async (t) => {
  const server = await serveLive(), publisher = publishTo(server.address);
  const { tab, close } = await open(server.address);
  await tab.addInitScript(() => { delete window.AudioDecoder; });
  await tab.reload();
  await watch(tab);
  assert.equal(await tab.evaluate("typeof AudioDecoder"), "undefined");
  await areTogether(tab, t, "as files");
  assert.equal(await trouble(tab), null);
  await close();
  for (const program of [publisher, server]) await program.end();
});

test("what is muted from the start is not sent before it is wanted", async () => {
  const server = await serveLive(), publisher = publishTo(server.address);
  const { tab, close } = await openTab(browser, `http://${server.address}/`, { requestsFail: true });
  const addresses = [];
  tab.on("websocket", (socket) => addresses.push(new URL(socket.url()).search));
  await tab.evaluate((src) => {
    document.body.innerHTML = `<pointreel-player src="${src}" muted controls autoplay></pointreel-player>`;
  }, `ws://${server.address}/live/alice`);
  await moves(tab);
  assert.equal(await ask(tab, "player.player.live[0].sound.hasBegun"), false);
  await ask(tab, "root.querySelector('[title=\"Sound on\"]').click()");
  await until(tab, () => document.querySelector("pointreel-player").player.live[0].sound.hasBegun, "sound comes", WAIT);
  const frames = await ask(tab, "player.player.live[0].frames");
  await until(tab, `document.querySelector("pointreel-player").player.live[0].frames > ${frames} + 3`, "the stream moves on", WAIT);
  assert.equal(await trouble(tab), null);
  await tab.mouse.click(200, 40);
  await tab.keyboard.press("M");
  assert.equal(await ask(tab, "player.player.content.liveSounds.output.sink.gain.gain.value"), 0);
  // The picture in the list asks for no sound either.
  assert.deepEqual([...new Set(addresses)], ["", "?sound"]);
  assert.equal(addresses.indexOf("?sound"), addresses.length - 1);
  await close();
  for (const program of [publisher, server]) await program.end();
});

test("a stream without sound has no button for it", async () => {
  const server = await serveLive(), publisher = publishTo(server.address, []);
  const { tab, close } = await open(server.address);
  await moves(tab);
  assert.equal(await ask(tab, "root.querySelector('[title=\"Sound off\"]').hidden"), true);
  await close();
  for (const program of [publisher, server]) await program.end();
});

test("damaged sound is one line, and pictures go on", async () => {
  const server = await serveLive(), publisher = publishTo(server.address);
  const { tab, close } = await open(server.address);
  const HEADER = 24;
  let damage = null;
  await tab.routeWebSocket(/\/live\/alice/, (page) => page.connectToServer().onMessage((message) => {
    const isSound = typeof message !== "string" && message.toString("latin1", 0, 4) === "PRS1";
    page.send(isSound && damage ? damage(message) : message);
  }));
  await tab.reload();
  await moves(tab);
  await tab.mouse.click(200, 40);
  const says = (text) => until(tab, `document.querySelector("pointreel-player").shadowRoot.querySelector(".trouble:not([hidden])")
    ?.textContent === ${JSON.stringify(text)} || ${JSON.stringify(text)} === "" && document.querySelector("pointreel-player").player.trouble === null`,
    `the page says "${text}"`, WAIT);
  const noises = {
    // A packet of no frames.
    "sound: cannot be decoded": (message) => Buffer.concat([message.subarray(0, HEADER), Buffer.from([3, 0])]),
    "sound: its header is damaged": (message) => {
      const changed = Buffer.from(message);
      changed[9] ^= 1;
      return changed;
    },
    "sound: is shorter than its header": (message) => message.subarray(0, 9),
  };
  for (const [text, change] of Object.entries(noises)) {
    damage = change;
    await says(text);
    const frames = await ask(tab, "player.player.live[0].frames");
    await until(tab, `document.querySelector("pointreel-player").player.live[0].frames > ${frames} + 10`, "pictures go on", WAIT);
    damage = null;
    await says("");
  }
  await until(tab, () => !Number.isNaN(document.querySelector("pointreel-player").player.live[0].sound.delayMs), "sound is back", WAIT);
  await close();
  for (const program of [publisher, server]) await program.end();
});

test.after(async () => {
  await browser.close();
});
