// Files through the WebAssembly module: node files.mjs MODULE TABLES
import assert from "node:assert";
import { Module } from "./module.mjs";

const module = new Module(...process.argv.slice(2));

/** How many points a file has. */
function points(text) {
  const name = Buffer.from("a.ply"), options = Buffer.alloc(11 * 8);
  const failed = module.with(Buffer.from(text), (bytes) => module.with(name, (nameAt) => module.with(options, (optionsAt) =>
    module.x.pr_prepare_file(1, bytes, text.length, nameAt, name.length, optionsAt))));
  if (failed) return module.error();
  return module.doubles(module.x.pr_frame(1), 3)[2];
}

const ply = ["ply", "format ascii 1.0", "element vertex 2", "property float x", "property float y", "property float z",
             "end_header", "1 2 3", "4 5 6", ""].join("\n");
assert.strictEqual(points(ply), 2);
assert.strictEqual(points(ply.replace("ply", "PLY")), 2);
assert.match(points(ply.replace("ply", "pla")), /neither a PLY nor a Draco file/);
