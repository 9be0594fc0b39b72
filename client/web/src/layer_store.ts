// Fetched layers of frames, within a bound, and the runs of bytes to fetch next.
import { Fetcher } from "./fetching";
import { FrameChunks } from "./pool";
import { Layers, Range, Reel } from "./reel";

const MOST_REQUESTS = 6;
const RUN_BYTES = 512 * 1024;

interface Run {
  layer: number;
  first: number;
  last: number;
  abort: AbortController;
}
const ALL: Omit<Layers, "first" | "end"> = { colors: 1, normals: 1 };

export class LayerStore {
  private readonly kept = new Map<number, (Uint8Array | undefined)[]>();
  private readonly ranges = new Map<number, Range[]>();
  private bytes = 0;
  private runs: Run[] = [];
  /** Why frames have fewer layers than the reel says: these are damaged or refused, and are not fetched any more. */
  readonly failed = new Map<number, string>();
  /** How many layers those frames have. */
  private readonly most = new Map<number, number>();

  constructor(private readonly reel: Reel, private readonly fetcher: Fetcher, private readonly room: number,
              private readonly onCame: () => void) {}

  get heldBytes(): number { return this.bytes; }

  /** How many layers a frame has, from the base on, of those wanted. */
  end(frame: number, wanted: Layers): number {
    return Math.min(wanted.end, this.most.get(frame) ?? this.rangesOf(frame).length);
  }
  /** From now on, a frame has no more layers than `end`, and `why` says so. */
  limit(frame: number, end: number, why: string): void {
    this.most.set(frame, Math.min(end, this.most.get(frame) ?? end));
    this.failed.set(frame, why);
  }
  has(frame: number, end: number): boolean {
    for (let i = 0; i < end; ++i) if (!this.hasLayer(frame, i)) return false;
    return true;
  }
  /** How many layers from the base on have come. */
  have(frame: number): number {
    let end = 0;
    while (this.hasLayer(frame, end)) ++end;
    return end;
  }
  /** With those frames that it is decoded after. */
  private hasLayer(frame: number, layer: number): boolean {
    if (!this.kept.get(frame)?.[layer]) return false;
    for (let other = this.reel.group(frame, layer).first; other < frame; ++other)
      if (!this.kept.get(other)?.[layer]) return false;
    return true;
  }

  /** What a frame is made of. */
  chunks(frame: number, layers: Layers, end: number): FrameChunks {
    if (this.reel.groupFrames > 0 && end > 1) return this.video(frame);
    const ranges = this.rangesOf(frame).slice(0, end), kept = this.kept.get(frame)!;
    const sizes = ranges.flatMap(({ sizes: [g, c, n] }) => [g, layers.colors ? c : 0, layers.normals ? n : 0]);
    const bytes = new Uint8Array(sizes.reduce((a, b) => a + b, 0));
    let at = 0;
    ranges.forEach(({ sizes: [g, c, n] }, i) => {
      const layer = kept[i]!, put = (from: number, size: number) => {
        bytes.set(layer.subarray(from, from + size), at);
        at += size;
      };
      put(0, g);
      if (layers.colors) put(g, c);
      if (layers.normals) put(g + c, n);
    });
    this.touch(frame);
    return { bytes, sizes: Uint32Array.from(sizes), video: null };
  }
  /** The frame's group, from its beginning, as far as it has come. */
  private video(frame: number): FrameChunks {
    const { first, frames } = this.reel.group(frame, 1), sizes: number[] = [], parts: Uint8Array[] = [];
    for (let other = first; other < first + frames; ++other) {
      const layer = this.kept.get(other)?.[1];
      if (!layer) break;
      parts.push(layer);
      sizes.push(...this.rangesOf(other)[1]!.sizes);
      this.touch(other);
    }
    const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
    let at = 0;
    for (const part of parts) {
      bytes.set(part, at);
      at += part.length;
    }
    return { bytes, sizes: Uint32Array.from(sizes), video: { group: first, index: frame - first } };
  }

  /**
   * Asks for layers of frames in the order of their urgency. The first frames are fetched one by
   * one, the others in runs of neighbours of up to `run` frames. Of those behind the first `begun`,
   * only requests that are under way go on.
   */
  want(frames: readonly { frame: number; end: number }[], urgent: number, run: number, begun: number): void {
    const wanted = new Map(frames.map(({ frame, end }) => [frame, end]));
    this.stopUnwanted(wanted);
    frames.forEach(({ frame, end }, i) => {
      if (i >= begun) return;
      for (let layer = 0; layer < end; ++layer) {
        if (this.runs.length >= MOST_REQUESTS) return;
        if (this.hasLayer(frame, layer) || this.isComing(frame, layer)) continue;
        this.start(frame, layer, i < urgent ? 1 : run, wanted);
      }
    });
  }
  /** What was fetched of a frame is damaged: it is fetched once more, with its group. */
  forget(frame: number): void {
    const { first, frames } = this.reel.group(frame, 1);
    for (let other = first; other < first + frames; ++other) {
      for (const layer of this.kept.get(other) ?? []) this.bytes -= layer?.length ?? 0;
      this.kept.delete(other);
    }
    this.fetcher.forgetFiles();
  }
  free(): void { for (const run of this.runs) run.abort.abort(); }

  private rangesOf(frame: number): Range[] {
    let ranges = this.ranges.get(frame);
    if (!ranges) {
      ranges = this.reel.ranges(frame, { first: 0, end: this.reel.layers, ...ALL });
      this.ranges.set(frame, ranges);
    }
    return ranges;
  }
  private isComing(frame: number, layer: number): boolean {
    return this.runs.some((run) => run.layer === layer && run.first <= frame && frame <= run.last);
  }
  private stopUnwanted(wanted: ReadonlyMap<number, number>): void {
    for (const run of this.runs) {
      let needed = false;
      for (let frame = run.first; frame <= run.last; ++frame)
        needed ||= (wanted.get(frame) ?? 0) > run.layer;
      if (!needed) run.abort.abort();
    }
    this.runs = this.runs.filter((run) => !run.abort.signal.aborted);
  }

  private sizeOf(frame: number, layer: number): number {
    const range = this.rangesOf(frame)[layer];
    return range ? range.sizes[0] + range.sizes[1] + range.sizes[2] : 0;
  }

  private start(frame: number, layer: number, most: number, wanted: ReadonlyMap<number, number>): void {
    const segment = this.reel.segment(frame), group = this.reel.group(frame, layer);
    const fits = (other: number) =>
      other >= segment.firstFrame && other < segment.firstFrame + segment.frames &&
      (wanted.get(other) ?? 0) > layer && this.sizeOf(other, layer) > 0 && !this.kept.get(other)?.[layer] &&
      !this.isComing(other, layer);
    let first = group.first, last = group.first + group.frames - 1, bytes = 0;
    for (let other = first; other <= last; ++other) bytes += this.sizeOf(other, layer);
    const grow = (other: number) => {
      if (last - first + 1 >= most || !fits(other)) return false;
      bytes += this.sizeOf(other, layer);
      return bytes <= RUN_BYTES || last - first + 1 < most / 2;
    };
    if (group.frames === 1) {
      while (grow(last + 1)) ++last;
      while (grow(first - 1)) --first;  // backward play
    }
    const run: Run = { layer, first, last, abort: new AbortController() };
    this.runs.push(run);
    const from = this.rangesOf(first)[layer]!.offset;
    const to = this.rangesOf(last)[layer]!.offset + this.sizeOf(last, layer);
    const path = this.reel.file(segment.number, layer), size = this.reel.fileBytes(segment.number, layer);
    this.fetcher.range(path, from, to, size, run.abort.signal)
      .then((body) => this.keep(run, body, from))
      .catch((error: Error) => {
        if (!run.abort.signal.aborted)
          for (let f = first; f <= last; ++f) this.limit(f, layer, error.message);
      })
      .finally(() => {
        this.runs = this.runs.filter((other) => other !== run);
        this.onCame();
      });
  }

  private keep(run: Run, body: Uint8Array, from: number): void {
    for (let frame = run.first; frame <= run.last; ++frame) {
      const range = this.rangesOf(frame)[run.layer];
      if (!range) continue;
      const layers = this.kept.get(frame) ?? [];
      if (layers[run.layer]) continue;
      const at = range.offset - from;
      // A copy, so that a frame that stays does not keep the bytes of its neighbours.
      layers[run.layer] = body.slice(at, at + this.sizeOf(frame, run.layer));
      this.bytes += layers[run.layer]!.length;
      this.kept.delete(frame);
      this.kept.set(frame, layers);
    }
    for (const [frame, layers] of this.kept) {
      if (this.bytes <= this.room) break;
      for (const layer of layers) this.bytes -= layer?.length ?? 0;
      this.kept.delete(frame);
    }
  }
  private touch(frame: number): void {
    const layers = this.kept.get(frame)!;
    this.kept.delete(frame);
    this.kept.set(frame, layers);
  }
}
