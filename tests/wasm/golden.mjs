// Every kept stream through the WebAssembly module: node golden.mjs MODULE TABLES STREAMS
// Each must give what the native decoder gave, all prefixes of its layers included.
import assert from "node:assert";
import fs from "node:fs";
import { Module, readFrame } from "./module.mjs";

const [path, tables, streams] = process.argv.slice(2);
const module = new Module(path, tables);
const codes = ["", "invalid", "unsupported", "limit", "argument", "not_found", "io", "cancelled",
               "refused"];

const hex = (hash) => hash.toString(16).padStart(16, "0");
function outcome(chunks, layers) {
  const at = module.withFrame(chunks, layers, (...frame) => module.x.pr_test_outcome(...frame, 0));
  if (at === 0) {
    assert.match(module.error(), /^[^\n]+$/);
    return { error: codes[module.x.pr_error_code()] };
  }
  const [depth, points, hasColors, hasNormals] = module.doubles(at, 4);
  const hashes = [...new BigUint64Array(module.x.memory.buffer, at + 32, 3)].map(hex);
  const result = { cells: hashes[0], depth, points };
  if (hasColors) result.colors = hashes[1];
  if (hasNormals) result.normals = hashes[2];
  const names = module.text(module.x.pr_test_fields()).split("\n").slice(0, -1);
  const values = new BigUint64Array(module.x.memory.buffer, module.x.pr_test_field_hashes(), names.length);
  if (names.length > 0) result.scalars = Object.fromEntries(names.map((name, i) => [name, hex(values[i])]));
  return result;
}

const expected = JSON.parse(fs.readFileSync(`${streams}/outcomes.json`, "utf8"));
let equal = 0;
const different = [];
for (const [name, kept] of Object.entries(expected)) {
  try {
    const chunks = readFrame(`${streams}/${name}.frame`);
    const layers = chunks.length / 3;
    if (kept.error) {
      assert.deepStrictEqual(outcome(chunks, layers), kept);
    } else {
      assert.strictEqual(layers, kept.layers.length);
      kept.layers.forEach((layer, i) => assert.deepStrictEqual(outcome(chunks, i + 1), layer));
      // A limit of memory that no frame with points keeps.
      if (kept.layers.at(-1).points > 0 && layers > 0) {
        const tight = module.withFrame(chunks, layers, (...frame) => module.x.pr_test_outcome(...frame, 1));
        assert.strictEqual(tight, 0);
        assert.strictEqual(codes[module.x.pr_error_code()], "limit");
      }
    }
    ++equal;
  } catch (error) {
    different.push(`${name}: ${error.message}`);
  }
}
console.log(`${equal} of ${Object.keys(expected).length} streams are equal`);
for (const line of different) console.log(line);
process.exit(different.length > 0 ? 1 : 0);
