// node mesh.mjs BUILD FOLDER: meshes of a reel, checked by Khronos's validator of glTF and played by three.js.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import validator from "gltf-validator";
import { AnimationMixer } from "three";

globalThis.self = globalThis;  // the loader is made for browsers
const { GLTFLoader } = await import("three/addons/loaders/GLTFLoader.js");

const [build, folder] = process.argv.slice(2);
const frames = 4, out = join(folder, "meshes");
const unpack = (...options) => execFileSync(join(build, "bin/pointreel-server"), ["unpack", "-i", join(folder, "reel"),
  "-o", out, "--force", "--mesh", "--format", "glb", "--frames", `0-${frames - 1}`, "--triangles", "3000", ...options]);

async function validated(name) {
  const bytes = new Uint8Array(readFileSync(join(out, name)));
  const { issues, info } = await validator.validateBytes(bytes);
  assert.deepEqual(issues.messages, [], name);
  return { bytes, info };
}

test("the file of each frame is valid", async () => {
  unpack();
  for (let i = 0; i < frames; ++i) {
    const { info } = await validated(`frame_0000${i}.glb`);
    assert.equal(info.animationCount, 0);
    assert.ok(info.totalTriangleCount > 2500 && info.totalTriangleCount <= 3000, info.totalTriangleCount);
  }
});

test("an animation is valid, and shows one frame at a time", async () => {
  unpack("--animation");
  const { bytes, info } = await validated("animation.glb");
  assert.equal(info.drawCallCount, frames);
  const { scene, animations } = await new GLTFLoader().parseAsync(bytes.buffer, "");
  const mixer = new AnimationMixer(scene), nodes = scene.children[0].children;
  mixer.clipAction(animations[0]).play();
  assert.equal(nodes.length, frames);
  for (let i = 0; i < frames; ++i) {
    mixer.setTime((i + 0.5) / frames * animations[0].duration);
    assert.deepEqual(nodes.map((node) => node.scale.x), nodes.map((_, k) => (k === i ? 1 : 0)), `frame ${i}`);
    const { geometry, material } = nodes[i];
    assert.ok(geometry.attributes.color && geometry.attributes.normal && material.vertexColors);
  }
});
