// Groups of video that a worker is decoding.
import { Prepare } from "./messages";
import { Module, ModuleError } from "./module";
import { Av1Decoder, COLOR_BITS, DecoderEnded, DEPTH_BITS, VideoError } from "./video_decoder";

/** Playback passes from one group to the next. */
const KEPT_GROUPS = 2;

/** A frame that was read, and its pictures, which may still be decoded. */
interface Pictures {
  /** PrVideoFrame. */
  handle: number;
  depth: Promise<VideoFrameLike>;
  colors: Promise<VideoFrameLike> | null;
}

function drop(module: Module, pictures: Pictures): void {
  module.call("pr_video_frame_free", pictures.handle);
  for (const picture of [pictures.depth, pictures.colors]) picture?.then((frame) => frame.close()).catch(() => undefined);
}

class Decoding {
  private readonly handle: number;
  private depth: Av1Decoder | null = null;
  private colors: Av1Decoder | null = null;
  /** The frame that is read next. */
  private next = 0;
  /** Read, and not taken yet. */
  private readonly ahead = new Map<number, Pictures>();

  constructor(private readonly module: Module, readonly group: number) { this.handle = module.made("pr_video_new"); }
  free(): void {
    for (const pictures of this.ahead.values()) drop(this.module, pictures);
    this.depth?.close();
    this.colors?.close();
    this.module.call("pr_video_free", this.handle);
  }
  /** Whether it can go on to a frame. */
  reaches(index: number): boolean { return index >= this.next || this.ahead.has(index); }

  /** The pictures of a frame, which are the caller's; those before it are decoded and forgotten. */
  take(job: Prepare, index: number): Pictures {
    this.readTo(job, index);
    for (const [other, pictures] of this.ahead) {
      if (other >= index) continue;
      drop(this.module, pictures);
      this.ahead.delete(other);
    }
    const pictures = this.ahead.get(index);
    if (!pictures) throw new VideoError("the video's group ends early");
    this.ahead.delete(index);
    return pictures;
  }
  /** Reads up to a frame, and gives the decoders what is read. */
  readTo(job: Prepare, index: number): void {
    const { sizes, bytes, options } = job;
    for (; this.next <= index && 3 * this.next < sizes.length; ++this.next) {
      const own = sizes.subarray(3 * this.next, 3 * this.next + 3), sum = (part: Uint32Array) => part.reduce((a, b) => a + b, 0);
      const from = sum(sizes.subarray(0, 3 * this.next)), chunks = bytes.subarray(from, from + sum(own));
      const [at, sizesAt] = this.module.put(chunks, own);
      const handle = this.module.made("pr_video_read", this.handle, at!, sizesAt!, options[4]!);
      const [width, height, depthAt, depthSize, colorsAt, colorsSize] = this.module.doubles(handle, 6);
      if (this.next === 0) {
        this.depth = new Av1Decoder(DEPTH_BITS, width!, height!);
        this.colors = colorsSize! > 0 ? new Av1Decoder(COLOR_BITS, width!, height!) : null;
      }
      const unit = (offset: number, size: number) => chunks.slice(offset, offset + size);
      const pictures: Pictures = {
        handle, depth: this.depth!.decode(this.next, unit(depthAt!, depthSize!)),
        colors: colorsSize! > 0 ? this.colors!.decode(this.next, unit(colorsAt!, colorsSize!)) : null,
      };
      // Whoever waits for them is told; nobody may ever wait.
      pictures.depth.catch(() => undefined);
      pictures.colors?.catch(() => undefined);
      this.ahead.set(this.next, pictures);
    }
  }
  async copy(pictures: Pictures, room: (bytes: number) => { depth: Uint8Array; colors: Uint8Array }): Promise<void> {
    const [width, height] = this.module.doubles(pictures.handle, 2);
    const frames = await Promise.all([pictures.depth, pictures.colors]);
    const { depth, colors } = room(width! * height!);
    await Promise.all([this.depth!.copy(frames[0]!, depth), frames[1] ? this.colors!.copy(frames[1], colors) : undefined]);
  }
}

export class VideoGroups {
  /** The one used last in front. */
  private decodings: Decoding[] = [];

  constructor(private readonly module: Module) {}

  /** Makes a frame of video as pr_prepare makes others. */
  async prepare(job: Prepare, tables: number): Promise<void> {
    try {
      await this.decode(job, tables);
    } catch (error) {
      if (!(error instanceof DecoderEnded)) throw error;
      await this.decode(job, tables);
    }
  }

  private async decode(job: Prepare, tables: number): Promise<void> {
    const { group, index } = job.video!, decoding = this.decodingOf(group, index), { module } = this;
    let pictures: Pictures | null = null, planes = 0;
    try {
      pictures = decoding.take(job, index);
      const colors = pictures.colors !== null;
      let pixels = 0;
      await decoding.copy(pictures, (count) => {
        pixels = count;
        planes = module.call("pr_alloc", pixels * 3 + (colors ? pixels * 3 / 2 : 0));
        if (planes === 0) throw new ModuleError("there is not enough memory for a frame");
        return { depth: module.bytes(planes, pixels * 3), colors: module.bytes(planes + pixels * 3, colors ? pixels * 3 / 2 : 0) };
      });
      this.readAhead(decoding, job, index + 1);
      const [options] = module.put(job.options);
      module.check("pr_prepare_video", job.key, pictures.handle, planes, colors ? planes + 3 * pixels : 0, tables, options!);
    } catch (error) {
      this.drop(decoding);
      throw error;
    } finally {
      module.call("pr_free", planes);
      if (pictures) drop(module, pictures);
    }
  }

  /** The browser decodes the next frame while this one is made. If it is damaged, that concerns only whoever asks for it. */
  private readAhead(decoding: Decoding, job: Prepare, index: number): void {
    try {
      decoding.readTo(job, index);
    } catch (error) {
      if (!(error instanceof ModuleError)) throw error;
      this.drop(decoding);
    }
  }
  private drop(decoding: Decoding): void {
    if (!this.decodings.includes(decoding)) return;
    this.decodings = this.decodings.filter((other) => other !== decoding);
    decoding.free();
  }

  private decodingOf(group: number, index: number): Decoding {
    const found = this.decodings.find((decoding) => decoding.group === group);
    const decoding = found?.reaches(index) ? found : new Decoding(this.module, group);
    if (found && found !== decoding) found.free();
    this.decodings = [decoding, ...this.decodings.filter((other) => other !== found)];
    for (const old of this.decodings.splice(KEPT_GROUPS)) old.free();
    return decoding;
  }
}
