// The typed side of wasm/module.h, which explains what is called here.

/** An error that the module has put into words. */
export class ModuleError extends Error {}

type Exports = Record<string, (...args: number[]) => number>;

/** Numbers of PrMode. */
export const MODES = ["surfel", "voxel", "point", "strip"] as const;
export type Mode = (typeof MODES)[number];
/** Numbers of PrColor. */
export const COLORS = ["colors", "normals", "plain", "curvature", "accessibility", "depth", "contours"] as const;
export type ColorSource = (typeof COLORS)[number];
/** Numbers of PrLight. */
export const LIGHTS = ["flat", "studio", "environment"] as const;
export type Light = (typeof LIGHTS)[number];
export const WHOLE_FRAME = 21;

/** An instance of the module: its memory, and calls that turn errors into exceptions. */
export class Module {
  private readonly memory: WebAssembly.Memory;
  /** For structures and texts that go in; no call keeps them. */
  private room = 0;
  private roomBytes = 0;
  private readonly utf8 = new TextDecoder();

  private constructor(readonly exports: Exports, memory: WebAssembly.Memory) {
    this.memory = memory;
  }

  static async create(compiled: WebAssembly.Module): Promise<Module> {
    const instance = await WebAssembly.instantiate(compiled, {});
    const exports = instance.exports as unknown as Exports;
    exports._initialize!();
    return new Module(exports, (instance.exports as { memory: WebAssembly.Memory }).memory);
  }

  call(name: string, ...args: number[]): number { return this.exports[name]!(...args); }

  /** For functions that return a PrError. */
  check(name: string, ...args: number[]): void {
    if (this.call(name, ...args) !== 0) throw this.lastError();
  }
  /** For functions that return a pointer, and 0 on failure. */
  made(name: string, ...args: number[]): number {
    const pointer = this.call(name, ...args);
    if (pointer === 0) throw this.lastError();
    return pointer;
  }
  lastError(): ModuleError { return new ModuleError(this.text(this.call("pr_error_text"))); }

  /** Copies of numbers in the module's memory. */
  doubles(pointer: number, count: number): Float64Array {
    return new Float64Array(this.memory.buffer, pointer, count).slice();
  }
  floats(pointer: number, count: number): Float32Array {
    return new Float32Array(this.memory.buffer, pointer, count).slice();
  }
  ints(pointer: number, count: number): Int32Array {
    return new Int32Array(this.memory.buffer, pointer, count).slice();
  }
  uints(pointer: number, count: number): Uint32Array {
    return new Uint32Array(this.memory.buffer, pointer, count).slice();
  }
  bytes(pointer: number, count: number): Uint8Array {
    return new Uint8Array(this.memory.buffer, pointer, count);
  }
  text(pointer: number): string {
    const all = new Uint8Array(this.memory.buffer);
    return this.utf8.decode(all.slice(pointer, all.indexOf(0, pointer)));
  }

  /** Puts bytes, one after another and each aligned to 16 bytes, where a call can read them. */
  put(...parts: readonly ArrayBufferView[]): number[] {
    const places: number[] = [];
    let end = 0;
    for (const part of parts) {
      places.push(end);
      end += (part.byteLength + 15) & ~15;
    }
    if (end > this.roomBytes) {
      this.call("pr_free", this.room);
      this.roomBytes = 0;
      this.room = this.call("pr_alloc", end + (end >> 2));
      if (this.room === 0) throw new ModuleError("there is not enough memory for a frame");
      this.roomBytes = end + (end >> 2);
    }
    parts.forEach((part, i) => {
      new Uint8Array(this.memory.buffer, this.room + places[i]!, part.byteLength)
        .set(new Uint8Array(part.buffer, part.byteOffset, part.byteLength));
    });
    return places.map((place) => this.room + place);
  }
  /** Calls `use` with a copy of so many bytes that their room should not be kept. */
  withBytes<Result>(bytes: Uint8Array, use: (at: number) => Result): Result {
    const at = this.call("pr_alloc", bytes.length);
    if (at === 0) throw new ModuleError("there is not enough memory");
    try {
      this.bytes(at, bytes.length).set(bytes);
      return use(at);
    } finally {
      this.call("pr_free", at);
    }
  }
  /** What a call has changed of what was put. */
  get heap(): ArrayBuffer { return this.memory.buffer; }
}

const encoder = new TextEncoder();
export const encode = (text: string): Uint8Array => encoder.encode(text);

export type Vec3 = [number, number, number];
export interface Box {
  min: Vec3;
  max: Vec3;
}
const vec3 = (from: ArrayLike<number>, at: number): Vec3 => [from[at]!, from[at + 1]!, from[at + 2]!];
export const isEmpty = (box: Box): boolean => box.min.some((low, i) => !(low <= box.max[i]!));

/** PrPacked, with the instances themselves in rows of a texture (fetch.glsl). */
export interface Packed {
  instances: ArrayBuffer;
  count: number;
  origin: Vec3;
  /** PrBounds. */
  bounds: Float64Array;
  normalsEstimated: boolean;
  visited: number;
  outOfView: number;
  hidden: number;
  /** Of strips: the last instances, which are points. The others are vertices. */
  points: number;
  /** Of vertices: triangles that face the eye, others, and those that are turned away, so many of each. */
  indices: Uint32Array;
  facing: number;
  mixed: number;
  turnedAway: number;
  /** With lighting: the strength of the flat light. */
  light: number;
  /** One in this many surfels keeps its back. */
  oneBackIn: number;
}
export const ROW_INSTANCES = 2048;
const INSTANCE_BYTES = 32;

export interface FrameFacts {
  index: number;
  timeUs: number;
  points: number;
  layers: number;
  level: number;
  depth: number;
  elements: number;
  isCloud: boolean;
  normalsEstimated: boolean;
  memory: number;
  /** Its boxes, for viewBox. */
  boxes: Float64Array;
  /** In more detail, they may be others. */
  roughBoxes: boolean;
  /** Of pr_legend. */
  legend: string;
}

export function frameFacts(module: Module, key: number): FrameFacts {
  const f = module.doubles(module.made("pr_frame", key), 23);
  return {
    index: f[0]!, timeUs: f[1]!, points: f[2]!, layers: f[3]!, level: f[4]!, depth: f[5]!,
    elements: f[6]!, isCloud: f[7] !== 0, normalsEstimated: f[8] !== 0, memory: f[9]!,
    boxes: f.slice(10, 22), roughBoxes: f[22] !== 0,
    legend: module.text(module.call("pr_legend", key)),
  };
}

/** The box that a first view frames. `bounds`: of all frames; `boxes`: of the first that is shown. */
export function viewBox(module: Module, bounds: Box, boxes: Float64Array): Box {
  const [all, first] = module.put(Float64Array.of(...bounds.min, ...bounds.max), boxes);
  const box = module.doubles(module.call("pr_view_box", all!, first!), 6);
  return { min: vec3(box, 0), max: vec3(box, 3) };
}

/** `view`: a PrView. */
export function pack(module: Module, key: number, view: Float64Array): Packed {
  const p = module.doubles(module.made("pr_pack", key, module.put(view)[0]!), 25);
  const count = p[1]!, rows = Math.max(1, Math.ceil(count / ROW_INSTANCES));
  const instances = new Uint8Array(rows * ROW_INSTANCES * INSTANCE_BYTES);
  instances.set(module.bytes(p[0]!, count * INSTANCE_BYTES));
  return {
    instances: instances.buffer, count, origin: vec3(p, 2), bounds: p.slice(5, 14),
    normalsEstimated: p[14] !== 0, visited: p[15]!, outOfView: p[16]!, hidden: p[17]!,
    points: p[18]!, indices: module.uints(p[19]!, p[20]! + p[21]! + p[22]!),
    facing: p[20]!, mixed: p[21]!, turnedAway: p[22]!, light: p[23]!, oneBackIn: p[24]!,
  };
}
