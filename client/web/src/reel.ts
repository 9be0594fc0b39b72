// A reel's manifest, read and checked by the module.
import { Box, MODES, Module, Vec3 } from "./module";
import { Camera } from "./camera";
import { ScalarRange } from "./colors";
import { Kind } from "./view";

export interface Layers {
  first: number;
  end: number;
  colors: number;
  normals: number;
}
/** Where the chunks of one layer of a frame are. */
export interface Range {
  layer: number;
  offset: number;
  sizes: [number, number, number];
}
export interface Segment {
  number: number;
  firstFrame: number;
  frames: number;
  cube: [number, number, number, number];
}

const TEXT = { name: 0, codec: 1, entropy: 2, layer: 3, tablesPath: 4, tablesChecksum: 5, session: 6, audioPath: 7, scalar: 8 };
/** PrReelInfo. */
const INFO_NUMBERS = 28;
const layersIn = (words: Int32Array): Layers =>
  ({ first: words[0]!, end: words[1]!, colors: words[2]!, normals: words[3]! });

/** The numbers of a PrReel, which may be that of a live stream. */
export const reelInfo = (module: Module, handle: number): Float64Array =>
  module.doubles(module.call("pr_reel_info", handle), INFO_NUMBERS);
const textOf = (module: Module, handle: number, which: keyof typeof TEXT, index: number): string =>
  module.text(module.call("pr_reel_text", handle, TEXT[which], index));
export function scalarsOf(module: Module, handle: number): ScalarRange[] {
  return Array.from({ length: reelInfo(module, handle)[25]! }, (_, i) => {
    const name = textOf(module, handle, "scalar", i);
    const [least, most, labels] = module.doubles(module.call("pr_reel_scalar", handle, i), 3);
    return { name, least: least!, most: most!, labels: labels !== 0 };
  });
}

export class Reel {
  readonly frames: number;
  readonly durationUs: number;
  readonly fps: number;
  readonly layers: number;
  readonly depthMax: number;
  readonly up: number;
  readonly bounds: Box;
  readonly tablesBytes: number;
  /** 0: it has no sound. */
  readonly audioBytes: number;
  readonly scalars: readonly ScalarRange[];
  /** Frames of a group whose video is decoded together; 0: it has no video. */
  readonly groupFrames: number;
  readonly normalsEstimated: boolean;
  readonly timesUs: Float64Array;
  /** Frames that are shown: in a cut of video, others only serve to decode these. */
  readonly shownFrames: number;
  /** For each frame, how many frames up to and including it are shown. */
  private readonly shownTo: Uint32Array;
  private readonly files = new Map<number, string>();
  private readonly groups = new Map<number, { first: number; frames: number }>();

  /** `handle`: a PrReel. */
  constructor(readonly module: Module, readonly handle: number) {
    const i = reelInfo(module, handle);
    this.frames = i[0]!;
    this.durationUs = i[1]!;
    this.fps = i[2]!;
    this.layers = i[4]!;
    this.depthMax = i[7]!;
    this.up = i[8]!;
    this.bounds = { min: [i[12]!, i[13]!, i[14]!] as Vec3, max: [i[15]!, i[16]!, i[17]!] as Vec3 };
    this.tablesBytes = i[19]!;
    this.audioBytes = i[24]!;
    this.scalars = scalarsOf(module, handle);
    this.groupFrames = i[26]!;
    this.normalsEstimated = i[27] !== 0;
    this.timesUs = module.doubles(module.call("pr_reel_times", handle), this.frames);
    this.shownTo = new Uint32Array(this.frames);
    let shown = 0;
    for (let i = 0; i < this.frames; ++i) {
      if (this.groupFrames === 0 || (this.timesUs[i + 1] ?? this.durationUs) > this.timesUs[i]!) ++shown;
      this.shownTo[i] = shown;
    }
    this.shownFrames = shown;
  }
  static read(module: Module, manifest: Uint8Array): Reel {
    const [text] = module.put(manifest);
    return new Reel(module, module.made("pr_reel_new", text!, manifest.length));
  }
  free(): void { this.module.call("pr_reel_free", this.handle); }

  /** The index of a frame among those that are shown. */
  shownIndex(frame: number): number { return Math.max(0, (this.shownTo[frame] ?? 1) - 1); }
  text(which: keyof typeof TEXT, index = 0): string { return textOf(this.module, this.handle, which, index); }
  segment(frame: number): Segment {
    const s = this.module.doubles(this.module.call("pr_reel_segment", this.handle, frame), 7);
    return { number: s[0]!, firstFrame: s[1]!, frames: s[2]!, cube: [s[3]!, s[4]!, s[5]!, s[6]!] };
  }
  /** The frames whose chunks of a layer are of use only together, for a frame of them. */
  group(frame: number, layer: number): { first: number; frames: number } {
    if (this.groupFrames === 0 || layer === 0) return { first: frame, frames: 1 };
    let group = this.groups.get(frame);
    if (!group) {
      const [first, frames] = this.module.doubles(this.module.call("pr_reel_group", this.handle, frame), 2);
      this.groups.set(frame, group = { first: first!, frames: frames! });
    }
    return group;
  }
  file(segment: number, layer: number): string {
    const key = segment * 8 + layer;
    let file = this.files.get(key);
    if (file === undefined) {
      file = this.module.text(this.module.call("pr_reel_file", this.handle, segment, layer));
      this.files.set(key, file);
    }
    return file;
  }
  fileBytes(segment: number, layer: number): number {
    return this.module.call("pr_reel_file_bytes", this.handle, segment, layer);
  }
  ranges(frame: number, layers: Layers): Range[] {
    const [at] = this.module.put(Uint32Array.of(layers.first, layers.end, layers.colors, layers.normals));
    const found = this.module.made("pr_reel_ranges", this.handle, frame, at!);
    const count = this.module.call("pr_reel_range_count"), r = this.module.doubles(found, 5 * count);
    return Array.from({ length: count }, (_, i): Range => ({
      layer: r[5 * i]!, offset: r[5 * i + 1]!, sizes: [r[5 * i + 2]!, r[5 * i + 3]!, r[5 * i + 4]!],
    }));
  }
  levelFor(camera: Camera, width: number, height: number, pixelSize: number): number {
    const [at] = this.module.put(camera.state);
    return this.module.call("pr_level_for", this.handle, at!, width, height, pixelSize);
  }
}

const numbersOf = ({ mode, normals, scalar }: Kind): [number, number, number] =>
  [MODES.indexOf(mode), Number(normals), Number(scalar !== null)];

/** What the link and the machine allow to be fetched: client/playback/layer_control.h. */
export class LayerControl {
  private readonly handle: number;

  constructor(private readonly reel: Reel, workers: number) {
    this.handle = reel.module.made("pr_control_new", reel.handle, workers, 1);
  }
  free(): void { this.reel.module.call("pr_control_free", this.handle); }
  carried(bytes: number, seconds: number): void {
    this.reel.module.call("pr_control_carried", this.handle, bytes, seconds);
  }
  made(layers: number, ms: number): void {
    this.reel.module.call("pr_control_made", this.handle, layers, ms);
  }
  forgetMade(): void { this.reel.module.call("pr_control_forget_made", this.handle); }
  /** PrSituation. */
  update(situation: Float64Array, kind: Kind): void {
    const [at] = this.reel.module.put(situation);
    this.reel.module.call("pr_control_update", this.handle, at!, ...numbersOf(kind));
  }
  /** `most`: no more layers are of use. */
  decide(kind: Kind, level: number, most: number): { layers: Layers; limit: number } {
    const [mode, normals, scalars] = numbersOf(kind);
    const at = this.reel.module.call("pr_control_decide", this.handle, mode, level, normals, scalars, most);
    const words = this.reel.module.ints(at, 5);
    return { layers: layersIn(words), limit: words[4]! };
  }
  get bytesPerSecond(): number { return this.reel.module.call("pr_control_rate", this.handle); }
}
