// node three.mjs TARBALL SERVER REEL: a reel in scenes of three.js. A plane shows where its surface is.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { openBrowser, until } from "./browser.mjs";
import { installPackage } from "./package_site.mjs";
import { openTab } from "./tab.mjs";

const installed = await installPackage(...process.argv.slice(2));
const { folder, site, server } = installed;
const browser = await openBrowser();
writeFileSync(join(folder, "scene.html"), `<!doctype html><link rel="icon" href="data:,">
<script type="importmap">{ "imports": { "three": "./node_modules/three/build/three.module.js",
  "pointreel-player/three": "./node_modules/pointreel-player/player/three.js" } }</script>
<canvas width="300" height="300"></canvas><script type="module" src="scene.js"></script>`);
writeFileSync(join(folder, "scene.js"), `
import * as THREE from "three";
import { PointreelObject } from "pointreel-player/three";

const options = Object.fromEntries(new URL(location).searchParams);
const renderer = new THREE.WebGLRenderer({ canvas: document.querySelector("canvas"), ...options });
const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(45, 1, 0.1, 50);
scene.background = new THREE.Color(0xff00ff);
const mesh = (color, map = null) => new THREE.Mesh(new THREE.PlaneGeometry(4, 4), new THREE.MeshBasicMaterial({ color, map, side: THREE.DoubleSide }));
const plane = mesh(0x00ff00), person = new PointreelObject(renderer);
person.player.adapt = () => undefined;  // pictures that come too slowly would have fewer pixels
// What is drawn after the reel, by a picture whose rows are turned over when it is uploaded: its upper half is blue.
const canvas = Object.assign(document.createElement("canvas"), { width: 2, height: 2 });
Object.assign(canvas.getContext("2d"), { fillStyle: "#0000ff" }).fillRect(0, 0, 2, 1);
const after = mesh(0xffffff, new THREE.CanvasTexture(canvas));
after.material.map.magFilter = THREE.NearestFilter;
after.material.alphaTest = 0.5;
after.position.y = 2.3;
after.renderOrder = 1;
scene.add(plane, after, person);
const loaded = person.load(${JSON.stringify(server.origin)} + "/walk");

function count() {
  renderer.render(scene, camera);
  const gl = renderer.getContext(), pixels = new Uint8Array(4 * 300 * 300);
  gl.readPixels(0, 0, 300, 300, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const found = { background: 0, plane: 0, after: 0, person: 0, highest: 0 };
  for (let i = 0; i < pixels.length; i += 4) {
    const color = pixels.subarray(i, i + 3).join();
    const what = { "255,0,255": "background", "0,255,0": "plane", "0,0,255": "after" }[color] ?? "person";
    ++found[what];
    if (what === "person") found.highest = Math.floor(i / 4 / 300);
  }
  return found;
}
const isSettled = () => {
  const { player } = person, { reel } = player, shown = reel?.shown;
  return shown && !reel.isSeeking && shown.look === player.lookNumber && shown.layers >= reel.store.end(shown.frame, reel.wanted);
};
/** How many pixels show what. The plane is at depth z; the camera is on the side \`from\`. */
async function look(z, from = 1) {
  plane.visible = z !== null;
  plane.position.z = z;
  camera.position.set(0, 1.2, 4 * from);
  camera.lookAt(0, 1.2, 0);
  for (let same = 0, end = performance.now() + 30000; performance.now() < end;) {
    const found = count();
    same = isSettled() ? same + 1 : 0;
    if (same > 2) return found;
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  throw new Error("the picture does not come to rest");
}
Object.assign(window, { THREE, renderer, scene, camera, person, loaded, look });
`);

const open = async (query = "", options = {}) => {
  const { tab, close } = await openTab(browser, `${site.origin}/scene.html${query}`, options);
  await until(tab, "window.loaded !== undefined", "the scene is made");
  await tab.evaluate("loaded");
  return { tab, close };
};

for (const kind of ["", "?logarithmicDepthBuffer=1", "?reversedDepthBuffer=1"]) {
  test(`a plane hides what is behind it and is hidden by what is before it ${kind}`, async () => {
    const { tab, close } = await open(kind);
    for (const side of [1, -1]) {
      const all = (await tab.evaluate(`look(null, ${side})`)).person;
      assert.ok(all > 2000, `${all} pixels of a person`);
      assert.equal((await tab.evaluate(`look(${-2 * side}, ${side})`)).person, all);
      assert.equal((await tab.evaluate(`look(${2 * side}, ${side})`)).person, 0);
      const before = (await tab.evaluate(`look(-0.7, ${side})`)).person;
      console.log(`# ${all} pixels, of which ${before} before the plane`);
      assert.ok(before > 0.1 * all && before < 0.9 * all);
    }
    await close();
  });
}

test("it stands on the floor in metres, moves as other objects do, and leaves them as they are", async () => {
  const { tab, close } = await open();
  const [width, height, depth] = await tab.evaluate("person.size");
  assert.ok(height >= 0.5 && height <= 3 && width > 0 && depth > 0);
  const whole = await tab.evaluate("look(null)");
  await tab.evaluate("person.scale.setScalar(0.5)");
  const half = await tab.evaluate("look(null)");
  // The picture's height is 2 * 4 * tan(22.5 degrees) at the person, and its lower edge 0.457 m below the floor.
  const top = (metres) => 300 * (metres + 0.457) / 3.314;
  assert.ok(Math.abs(whole.highest - top(height)) < 20 && Math.abs(half.highest - top(height / 2)) < 15,
            `${height} m reach row ${whole.highest}, half of it ${half.highest}`);
  assert.ok(Math.abs(half.person / whole.person - 0.3) < 0.1, `${half.person} of ${whole.person} pixels`);
  assert.ok(whole.after > 500 && half.after === whole.after, "the object drawn after it");
  await close();
});

test("it plays, seeks, tells what is wrong, and can be removed", async () => {
  const { tab, close } = await open("", { requestsFail: true });
  await tab.evaluate("(renderer.setAnimationLoop(() => renderer.render(scene, camera)), person.play())");
  await until(tab, "person.frame > 3 && !person.paused", "frames advance");
  await tab.evaluate("(person.pause(), person.currentTime = 2)");
  await until(tab, "person.frame === 60", "the frame at 2 s");
  assert.equal(await tab.evaluate("person.duration"), 3);
  assert.match(await tab.evaluate(`person.load("${site.origin}/nothing").catch((error) => error.message)`), /404/);
  await tab.evaluate("(scene.remove(person), person.dispose())");
  await tab.evaluate("new Promise((resolve) => setTimeout(resolve, 300))");
  await tab.evaluate("renderer.setAnimationLoop(null)");
  await close();
});

test("the example plays", async () => {
  const { tab, close } = await openTab(browser, `${site.origin}/three.html`);
  const first = await tab.screenshot(), end = Date.now() + 30_000;
  while ((await tab.screenshot()).equals(first)) assert.ok(Date.now() < end, "nothing moves");
  assert.equal(await tab.evaluate("document.querySelector('output').textContent"), "");
  await close();
});

test.after(async () => {
  await browser.close();
  installed.close();
});
