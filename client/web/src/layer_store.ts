// Fetched layers of frames, within a bound, and the runs of bytes to fetch next.
import { Fetcher } from "./fetching";
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
  /** Damaged or refused: no more is fetched of it. */
  readonly failed = new Map<number, string>();

  constructor(private readonly reel: Reel, private readonly fetcher: Fetcher, private readonly most: number,
              private readonly onCame: () => void) {}

  get heldBytes(): number { return this.bytes; }

  /** How many layers a frame has, from the base on, of those wanted. */
  end(frame: number, wanted: Layers): number {
    return Math.min(wanted.end, this.rangesOf(frame).length);
  }
  has(frame: number, end: number): boolean {
    const layers = this.kept.get(frame);
    for (let i = 0; i < end; ++i) if (!layers?.[i]) return false;
    return true;
  }
  /** How many layers from the base on have come. */
  have(frame: number): number {
    const layers = this.kept.get(frame);
    let end = 0;
    while (layers?.[end]) ++end;
    return end;
  }

  /** The chunks of the first layers of a frame, as pr_prepare takes them. */
  chunks(frame: number, layers: Layers, end: number): { bytes: Uint8Array; sizes: Uint32Array } {
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
    return { bytes, sizes: Uint32Array.from(sizes) };
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
      if (i >= begun || this.failed.has(frame)) return;
      for (let layer = 0; layer < end; ++layer) {
        if (this.runs.length >= MOST_REQUESTS) return;
        if (this.kept.get(frame)?.[layer] || this.isComing(frame, layer)) continue;
        this.start(frame, layer, i < urgent ? 1 : run, wanted);
      }
    });
  }
  /** What was fetched of a frame is damaged: it is fetched once more. */
  forget(frame: number): void {
    for (const layer of this.kept.get(frame) ?? []) this.bytes -= layer?.length ?? 0;
    this.kept.delete(frame);
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
    const segment = this.reel.segment(frame);
    const fits = (other: number) =>
      other >= segment.firstFrame && other < segment.firstFrame + segment.frames &&
      (wanted.get(other) ?? 0) > layer && this.sizeOf(other, layer) > 0 && !this.kept.get(other)?.[layer] &&
      !this.isComing(other, layer) && !this.failed.has(other);
    let first = frame, last = frame, bytes = this.sizeOf(frame, layer);
    const grow = (other: number) => {
      if (last - first + 1 >= most || !fits(other)) return false;
      bytes += this.sizeOf(other, layer);
      return bytes <= RUN_BYTES || last - first + 1 < most / 2;
    };
    while (grow(last + 1)) ++last;
    while (grow(first - 1)) --first;  // backward play
    const run: Run = { layer, first, last, abort: new AbortController() };
    this.runs.push(run);
    const from = this.rangesOf(first)[layer]!.offset;
    const to = this.rangesOf(last)[layer]!.offset + this.sizeOf(last, layer);
    const path = this.reel.file(segment.number, layer), size = this.reel.fileBytes(segment.number, layer);
    this.fetcher.range(path, from, to, size, run.abort.signal)
      .then((body) => this.keep(run, body, from))
      .catch((error: Error) => {
        if (!run.abort.signal.aborted)
          for (let f = first; f <= last; ++f) this.failed.set(f, error.message);
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
      const at = range.offset - from;
      // A copy, so that a frame that stays does not keep the bytes of its neighbours.
      layers[run.layer] = body.slice(at, at + this.sizeOf(frame, run.layer));
      this.bytes += layers[run.layer]!.length;
      this.kept.delete(frame);
      this.kept.set(frame, layers);
    }
    for (const [frame, layers] of this.kept) {
      if (this.bytes <= this.most) break;
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
