// The WebAssembly module for tests in Node.
import fs from "node:fs";

export class Module {
  constructor(path, tables) {
    const module = new WebAssembly.Module(fs.readFileSync(path));
    const imports = WebAssembly.Module.imports(module);
    if (imports.length > 0) throw new Error(`${path} imports ${imports.map((i) => i.name)}`);
    this.x = new WebAssembly.Instance(module, {}).exports;
    this.x._initialize();
    const bytes = fs.readFileSync(tables);
    if (this.with(bytes, (at) => this.x.pr_load_tables(at, bytes.length))) throw new Error(this.error());
  }

  // Calls use(pointer) with a copy of the bytes in the module's memory.
  with(bytes, use) {
    const at = this.x.pr_alloc(bytes.length);
    new Uint8Array(this.x.memory.buffer, at, bytes.length).set(bytes);
    const result = use(at);
    this.x.pr_free(at);
    return result;
  }

  // Calls use(bytes, sizes, layers) with the first layers of a frame: chunks in threes.
  withFrame(chunks, layers, use) {
    const parts = chunks.slice(0, 3 * layers);
    const sizes = Uint32Array.from(parts, (part) => part.length);
    const sizesAsBytes = new Uint8Array(sizes.buffer);
    return this.with(Buffer.concat(parts), (at) => this.with(sizesAsBytes, (sizesAt) => use(at, sizesAt, layers)));
  }

  text(at) {
    const memory = Buffer.from(this.x.memory.buffer);
    return memory.toString("utf8", at, memory.indexOf(0, at));
  }

  error() {
    return this.text(this.x.pr_error_text());
  }

  doubles(at, count) {
    return [...new Float64Array(this.x.memory.buffer, at, count)];
  }
}

// The chunks of a file of tests/golden/streams: geometry, colours and normals of each layer.
export function readFrame(path) {
  const file = fs.readFileSync(path);
  const chunks = [];
  for (let at = 4, left = 3 * file.readUInt32LE(0); left > 0; --left) {
    const size = file.readUInt32LE(at);
    chunks.push(file.subarray(at + 4, at + 4 + size));
    at += 4 + size;
  }
  return chunks;
}
