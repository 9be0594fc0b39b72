// node nginx.mjs BUILD FOLDER: nginx alone serves the page and a reel, configured by server/nginx/page.conf.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { accessSync, cpSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, settled, until } from "./browser.mjs";
import { start } from "./programs.mjs";
import { ask, openTab } from "./tab.mjs";

const [build, folder] = process.argv.slice(2);
const NGINX = "/usr/sbin/nginx";
try {
  accessSync(NGINX);
} catch {
  console.log("Skipped: nginx is not installed: apt-get install nginx");
  process.exit(77);
}

/** nginx cannot choose a free port and report it. */
const freePort = () => new Promise((resolve) => {
  const probe = createServer().listen(0, "127.0.0.1", () => {
    const { port } = probe.address();
    probe.close(() => resolve(port));
  });
});
const port = await freePort();
const site = join(folder, "site"), own = join(folder, "nginx");
cpSync(join(folder, "reel"), join(site, "reel"), { recursive: true });
execFileSync(join(build, "bin/pointreel-server"), ["page", site]);
mkdirSync(own);
const source = new URL("../../../server/nginx/page.conf", import.meta.url);
const http = [["listen 80;", `listen 127.0.0.1:${port};`], ["/srv/pointreel", site]].reduce((text, [from, to]) => {
  assert.ok(text.includes(from), `page.conf does not contain "${from}"`);
  return text.replace(from, to);
}, readFileSync(source, "utf8"));
writeFileSync(join(own, "nginx.conf"), `${process.getuid() === 0 ? "user root;\n" : ""}daemon off;
pid nginx.pid;
events {}
http {
  access_log off;
  ${["client_body", "proxy", "fastcgi", "uwsgi", "scgi"].map((name) => `${name}_temp_path ${name};`).join("\n  ")}
${http}
}
`);
const nginx = start(NGINX, ["-p", own, "-c", join(own, "nginx.conf"), "-e", join(own, "error.log")]);
const browser = await openBrowser();
const url = `http://127.0.0.1:${port}`;
for (const end = Date.now() + 30_000; !(await fetch(url).catch(() => null));) {
  assert.ok(Date.now() < end, readFileSync(join(own, "error.log"), "utf8"));
  await new Promise((resolve) => setTimeout(resolve, 50));
}

test("the page and a reel come from nginx alone", async () => {
  const { tab, close } = await openTab(browser, `${url}/index.html?reel=reel/reel.json#t=1`);
  await settled(tab);
  await ask(tab, "player.currentTime = player.player.reel.reel.timesUs[70] / 1e6");
  await settled(tab);
  assert.equal(await ask(tab, "player.frame"), 70);
  if (process.env.KEEP) await tab.screenshot({ path: join(process.env.KEEP, "nginx.png") });
  await close();
});

test("a page of one's own may lie beside the reels, and embed the player", async () => {
  // The files of the npm package are those of the page.
  const [page] = readdirSync(join(site, "page"));
  cpSync(join(site, "page", page), join(site, "node_modules/pointreel-player/player"), { recursive: true });
  writeFileSync(join(site, "my.css"), "h1 { color: rgb(1, 2, 3); }");
  writeFileSync(join(site, "my.html"), `<!DOCTYPE html><link rel="stylesheet" href="my.css"><h1>my page</h1>
    <script type="module" src="node_modules/pointreel-player/player/element.js"></script>
    <pointreel-player src="reel/reel.json" style="display: block; width: 320px; height: 200px"></pointreel-player>
    <iframe src="index.html?reel=reel/reel.json"></iframe>`);
  const { tab, close } = await openTab(browser, `${url}/my.html`);
  await until(tab, () => document.querySelector("pointreel-player")?.player?.pictures > 0, "a picture", 60_000);
  assert.deepEqual(await tab.evaluate(() => [document.querySelector("pointreel-player").clientWidth,
                                             document.querySelector("pointreel-player").clientHeight,
                                             getComputedStyle(document.querySelector("h1")).color]),
                   [320, 200, "rgb(1, 2, 3)"]);
  await until(tab, () => frames[0].document.querySelector("pointreel-player")?.player?.pictures > 0, "a frame", 60_000);
  await close();
  assert.equal((await fetch(`${url}/other.html`)).status, 404);
  assert.equal((await fetch(`${url}/node_modules/pointreel-player/package.json`)).status, 404);
});

test("the address of the folder lists the packages, and that of a package plays it", async () => {
  const { tab, close } = await openTab(browser, `${url}/`);
  await until(tab, () => document.querySelectorAll(".cards a").length === 1, "the list");
  await tab.goto(await tab.evaluate(() => document.querySelector(".cards a").href));
  await until(tab, () => document.querySelector("pointreel-player")?.player.pictures > 0, "a picture", 60_000);
  await close();
  const other = await openTab(browser, `${url}/reel`);
  await until(other.tab, () => document.querySelector("pointreel-player")?.player.pictures > 0, "a picture", 60_000);
  await other.close();
});

test("modules are compiled as they come, files with a hash are kept, and the policy is strict", async () => {
  const start = await fetch(`${url}/index.html`), html = await start.text();
  assert.equal(start.headers.get("Cache-Control"), "no-cache");
  assert.match(start.headers.get("Content-Security-Policy"), /^default-src 'none'/);
  const [hash] = /page\/[^/"]+/.exec(html);
  const module = await fetch(`${url}/${hash}/pointreel.wasm`);
  assert.equal(module.headers.get("Content-Type"), "application/wasm");
  assert.match(module.headers.get("Cache-Control"), /immutable/);
  assert.equal((await fetch(`${url}/reel/notes`)).status, 404);
});

test.after(async () => {
  await browser.close();
  await nginx.end();
});
