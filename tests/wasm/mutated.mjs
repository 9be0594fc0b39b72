// Damaged frames through the functions that the page calls: node mutated.mjs MODULE TABLES STREAMS
// Kept streams with bits, bytes and sizes changed, 40,000 times. Each must be prepared or refused with a line;
// none may trap. A frame that hangs makes the test run into its time limit.
import assert from "node:assert";
import fs from "node:fs";
import { Module, readFrame } from "./module.mjs";

const [path, tables, streams] = process.argv.slice(2);
const module = new Module(path, tables);
const names = fs.readdirSync(streams).filter((name) => name.endsWith(".frame")).sort();

let state = 1;
const random = (below) => {  // xorshift: the same mutations in every run
  state ^= state << 13;
  state ^= state >>> 17;
  state ^= state << 5;
  return (state >>> 0) % below;
};

function mutate(chunks) {
  const changed = chunks.map((chunk) => Buffer.from(chunk));
  for (let i = 1 + random(3); i > 0; --i) {
    const at = random(changed.length), chunk = changed[at];
    if (chunk.length === 0) continue;
    const place = random(chunk.length);
    const how = random(3);
    if (how === 0) chunk[place] ^= 1 << random(8);
    if (how === 1) chunk[place] = random(256);
    if (how === 2) changed[at] = chunk.subarray(0, place);
  }
  return changed;
}

// PrPrepare: mode, level, delta, show_normals, max_memory, index, time_us, cube_origin, cube_edge, normals_estimated
const options = (mode) => Buffer.from(Float64Array.of(mode, 21, -1, 0, 64 << 20, 0, 0, 0, 0, 0, 1, random(2)).buffer);
// PrView: camera, width, height, pixel_size, widen, mode, color, fill_holes, refine, place
const view = (mode) => Buffer.from(Float64Array.of(0.5, 0.5, 0.5, 3, 0, 0, 0.7, 1, 2, 320, 240, 1, 1.1, mode, 0, 1, random(2), 0, 0, 0).buffer);

// PrScalar: least, most, known, source
const scalar = () => Buffer.from(Float64Array.of(random(2) ? NaN : 1, 2, random(2), 0, 10, random(2)).buffer);
const FIELDS = ["", "class", "height", "patchy"].map((name) => Buffer.from(name));

const FRAMES = 40_000;
let prepared = 0;
for (let frame = 0; frame < FRAMES; ++frame) {
  const name = names[frame % names.length];
  const chunks = mutate(readFrame(`${streams}/${name}`));
  const mode = random(3);
  try {
    const field = FIELDS[random(FIELDS.length)];
    const error = module.with(options(mode), (how) => module.with(field, (name) => module.with(scalar(), (range) =>
      module.withFrame(chunks, chunks.length / 3,
                       (...frame) => module.x.pr_prepare(1, ...frame, 0, how, name, field.length, range)))));
    if (error === 0) {
      ++prepared;
      assert.notStrictEqual(module.with(view(mode), (at) => module.x.pr_pack(1, at)), 0);
      assert.match(module.text(module.x.pr_legend(1)), /^$|^(class|height|patchy)\n(ramp|labels)(\n[0-9a-f]{6} .*)*$/);
    } else {
      assert.match(module.error(), /^[^\n]+$/);
    }
  } catch (error) {
    console.log(`${name}, mutation ${frame}: ${error}`);
    process.exit(1);
  }
}
module.x.pr_drop_all();
console.log(`${FRAMES} frames, ${prepared} of them prepared`);
assert.ok(prepared > 0 && prepared < FRAMES);
