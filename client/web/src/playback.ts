// A reel that plays: its clock decides what is shown, and what is fetched and made ready next.
import { Clock } from "./clock";
import { DECODE_BYTES, FRAME_BYTES, STORE_BYTES } from "./device";
import { Fetcher } from "./fetching";
import { LayerStore } from "./layer_store";
import { Times } from "./messages";
import { FrameFacts, Packed, WHOLE_FRAME } from "./module";
import { LostJob, Pool, UndecodableVideo } from "./pool";
import { LayerControl, Layers, Reel } from "./reel";
import { fits, Kind, kindOf, Look, preparation, viewOf } from "./view";

const FETCH_AHEAD = 2;  // seconds
const MAKE_AHEAD = 8;   // frames
const RESUME = 0.1;     // seconds that must have come after a stall

/** A frame that is ready to draw, and what was packed of it last. */
export interface MadeFrame extends Kind {
  frame: number;
  worker: number;
  life: number;
  key: number;
  layers: number;
  /** What was wanted when it was made. */
  level: number;
  facts: FrameFacts;
  packed: Packed;
  look: number;
  times: Times;
}

export interface Counts {
  shown: number;
  dropped: number;
  errors: number;
  stalls: number;
}

let nextKey = 1;

export class ReelPlayback {
  readonly clock: Clock;
  readonly control: LayerControl;
  readonly store: LayerStore;
  readonly counts: Counts = { shown: 0, dropped: 0, errors: 0, stalls: 0 };
  shown: MadeFrame | null = null;
  /** The last decision: how many layers, and why not more (PrLimit). */
  limit = 0;
  wanted: Layers = { first: 0, end: 1, colors: 1, normals: 1 };
  /** Why no video is decoded, and only the octrees below it are shown; or null. */
  noVideo: string | null = null;
  /** Why the current frame cannot be shown. */
  error: string | null = null;
  scrubbing = false;
  private readonly made = new Map<number, MadeFrame>();
  private readonly making = new Map<number, number>();  // layers
  private readonly refetched = new Set<number>();
  private seeking: "jump" | "starved" | null = "jump";
  private packing = false;
  private updated = 0;
  private level = 0;
  private levelLook = -1;
  private lastShown = -1;

  constructor(readonly reel: Reel, private readonly pool: Pool, private readonly fetcher: Fetcher,
              private readonly tables: number, loop: boolean, private readonly onReady: () => void) {
    this.clock = new Clock(reel.module, reel.timesUs, Math.max(1, reel.durationUs), loop);
    this.control = new LayerControl(reel, pool.size);
    this.store = new LayerStore(reel, fetcher, STORE_BYTES, onReady);
  }
  free(): void {
    this.store.free();
    this.clear();
    this.control.free();
    this.clock.free();
    this.reel.free();
  }

  /** The exact frame is not shown yet. */
  get isSeeking(): boolean { return this.seeking === "jump"; }
  get isWaiting(): boolean { return this.seeking !== null; }

  play(): void {
    this.clock.play();
    this.jump();
  }
  pause(): void {
    this.clock.pause();
    this.clock.release();
    if (this.seeking === "starved") this.seeking = null;
  }
  seek(us: number): void {
    this.clock.seek(us);
    this.jump();
  }
  seekBy(us: number): void {
    this.clock.seekBy(us);
    this.jump();
  }
  step(frames: number): void {
    this.clock.step(frames);
    this.clock.release();
    this.jump();
  }
  private jump(): void {
    this.seeking = "jump";
    this.lastShown = -1;
    if (this.clock.state().playing) this.clock.hold();
  }

  /** Brings everything up to date; returns whether another picture is shown. */
  update(look: Look): boolean {
    const reading = this.clock.read(), state = this.clock.state();
    if (look.number !== this.levelLook) {
      this.levelLook = look.number;
      this.level = look.scalar ? WHOLE_FRAME : this.reel.levelFor(look.camera, look.width, look.height, look.pixelSize);
    }
    if (look.pixelSize > 1) this.dropFiner();
    this.decide(look, state.speed, state.playing);
    const upcoming = this.upcoming(reading.frame, state.speed < 0 ? -1 : 1, state.loop, state.range);
    this.fetch(reading.frame, upcoming, state.playing, state.speed);
    this.make(look, reading.frame, upcoming);
    const changed = this.show(look, reading.frame, state.speed < 0 ? -1 : 1);
    this.hold(reading.frame, upcoming, state.playing, state.speed);
    this.repack(look);
    this.trim(reading.frame, upcoming);
    this.error = this.store.failed.get(reading.frame) ?? null;
    return changed;
  }

  /** Frames in the order in which they will be shown, without the current one. */
  private upcoming(frame: number, direction: number, loop: boolean,
                   range: { first: number; last: number } | null): number[] {
    const { module, frames, fps } = this.reel, speed = Math.abs(this.clock.state().speed);
    const order = Int32Array.of(frames, Number(loop), direction, range?.first ?? -1, range?.last ?? -1);
    const count = Math.min(Math.ceil(FETCH_AHEAD * fps * speed), 240, frames - 1), result: number[] = [];
    const [at] = module.put(order);
    for (let step = 1; step <= count; ++step) {
      const next = module.call("pr_order_after", at!, frame, step);
      if (next < 0) break;
      result.push(next);
    }
    return result;
  }

  private decide(look: Look, speed: number, playing: boolean): void {
    const now = performance.now();
    if (now - this.updated > 100) {
      this.updated = now;
      const use = this.fetcher.takeUse();
      this.control.carried(use.bytes, use.seconds);
      const window = Math.max(1, Math.min(Math.ceil(FETCH_AHEAD * this.reel.fps * Math.abs(speed)), this.reel.frames - 1));
      const ahead = Math.min(MAKE_AHEAD, window);
      const fetched = this.ahead.fetched, made = this.ahead.made;
      this.control.update(Float64Array.of(
        now / 1000, Number(playing && !this.scrubbing),
        1 / (Math.max(this.reel.fps, 1e-3) * Math.abs(speed)),
        Math.min(1, fetched / window), Math.min(fetched, ahead) / ahead, Math.min(made, ahead) / ahead,
        this.ahead.next), kindOf(look));
    }
    const decision = this.control.decide(kindOf(look), this.level, this.noVideo === null ? 255 : 1);
    this.wanted = decision.layers;
    this.limit = decision.limit;
  }
  private ahead = { fetched: 0, made: 0, next: 0 };

  private fetch(frame: number, upcoming: readonly number[], playing: boolean, speed: number): void {
    const now = { frame, end: this.store.end(frame, this.scrubbing ? { ...this.wanted, end: 1 } : this.wanted) };
    const later = this.scrubbing ? [] : upcoming.map((f) => ({ frame: f, end: this.store.end(f, this.wanted) }));
    const fetched = later.findIndex((f) => !this.store.has(f.frame, f.end));
    this.ahead.fetched = fetched < 0 ? later.length : fetched;
    this.ahead.next = fetched < 0 ? frame : later[fetched]!.frame;
    const missing = later.length - this.ahead.fetched;
    const fps = this.reel.fps * Math.abs(speed);
    const run = Math.max(Math.ceil(fps * this.wanted.end / 20), Math.min(Math.ceil(fps / 2), 30));
    // Waiting until a whole run is missing keeps requests few. The current frame comes first.
    const refill = this.ahead.fetched < 8 || missing >= run || !playing;
    const waits = !this.store.has(frame, now.end);
    this.store.want([now, ...later], 1, run, waits ? 1 : refill ? later.length + 1 : 1);
  }

  private isGood(made: MadeFrame | undefined, look: Look, end: number): boolean {
    return !!made && fits(made, look) && made.life === this.pool.life(made.worker) &&
      made.layers >= end && (made.level >= this.level || made.facts.level >= this.level);
  }

  private make(look: Look, frame: number, upcoming: readonly number[]): void {
    const frames = this.scrubbing ? [frame] : [frame, ...upcoming.slice(0, MAKE_AHEAD)];
    let made = 0;
    frames.forEach((f, i) => {
      const end = this.store.end(f, this.wanted), have = Math.min(end, this.store.have(f));
      if (i > 0 && this.isGood(this.made.get(f), look, end)) ++made;
      if (have === 0) return;
      // A coarse picture of what is waited for is better than none.
      const isUrgent = i === 0 && !this.isGood(this.made.get(f), look, 1);
      if (have < end && !isUrgent) return;
      // After a jump, the octree below a video is there long before it is decoded. Playing, it is worse than the frame before.
      const isBase = isUrgent && this.isSeeking && this.reel.groupFrames > 0 && !this.making.has(f);
      const most = isBase ? 1 : have;
      if (this.isGood(this.made.get(f), look, most) || (this.making.get(f) ?? 0) >= most) return;
      const worker = this.pool.idlest();
      if (this.pool.load(worker) >= (i === 0 ? 2 : 1)) return;
      this.makeOne(look, f, most, worker);
    });
    this.ahead.made = made;
  }

  private makeOne(look: Look, frame: number, end: number, worker: number): void {
    const chunks = this.store.chunks(frame, this.wanted, end);
    const segment = this.reel.segment(frame), key = nextKey++, { number } = look;
    const level = this.level, life = this.pool.life(worker);
    const how = preparation(look, level, frame, this.reel.timesUs[frame]!, segment.cube, DECODE_BYTES, this.reel);
    this.making.set(frame, end);
    this.pool.prepare(worker, key, chunks, this.tables, how, viewOf(look)).then((done) => {
      this.control.made(end, done.times.prepareMs);
      const old = this.made.get(frame);
      if (old) this.drop(old);
      this.made.set(frame, { ...kindOf(look), frame, worker, life, key, layers: end, level, facts: done.facts,
                             packed: done.packed, look: number, times: done.times });
    }).catch((error: Error) => {
      if (error instanceof LostJob) return;
      if (error instanceof UndecodableVideo) {
        this.noVideo = error.message;
        return;
      }
      this.counts.errors += 1;
      const group = this.reel.group(frame, end - 1);
      if (this.refetched.has(group.first)) {
        // Whatever was wrong, those after it in its group need it.
        for (let f = frame; f < group.first + group.frames; ++f)
          this.store.limit(f, end > 1 ? 1 : 0, `frame ${f}: ${error.message}`);
      } else {
        this.refetched.add(group.first);
        this.store.forget(frame);
      }
    }).finally(() => {
      this.making.delete(frame);
      this.onReady();
    });
  }

  private show(look: Look, frame: number, direction: number): boolean {
    // Once there was a picture of the wanted kind, none of another is shown.
    const isFirst = !this.shown || !fits(this.shown, look);
    const usable = (made: MadeFrame | undefined) => (made && (isFirst || fits(made, look)) ? made : undefined);
    let best = usable(this.made.get(frame));
    if (!best && !this.isSeeking && !this.scrubbing && this.shown) {
      // The newest one between what is shown and what is due.
      for (let back = 1; back < MAKE_AHEAD && !best; ++back) {
        const other = frame - direction * back;
        if (other === this.shown.frame) break;
        best = usable(this.made.get(other));
      }
    }
    if (!best || best === this.shown) return false;
    if (best.frame !== this.lastShown) {
      this.counts.shown += 1;
      const skipped = Math.abs(best.frame - this.lastShown) - 1;
      if (this.lastShown >= 0 && this.clock.state().playing && skipped > 0 && skipped < this.reel.frames / 2)
        this.counts.dropped += skipped;
      this.lastShown = best.frame;
    }
    this.shown = best;
    return true;
  }

  /** Time stands still while what is needed has not come. */
  private hold(frame: number, upcoming: readonly number[], playing: boolean, speed: number): void {
    if (this.seeking === "jump") {
      const end = this.store.end(frame, this.scrubbing ? { ...this.wanted, end: 1 } : this.wanted);
      // The octree below a video only fills the time until that is decoded.
      const isThere = this.shown?.frame === frame && (this.reel.groupFrames === 0 || this.shown.layers >= end);
      if (!isThere && end > 0) return;
      // A picture alone is not enough to play on from.
      this.seeking = playing && upcoming.length > 0 && this.ahead.fetched === 0 ? "starved" : null;
      if (!this.seeking) this.clock.release();
    } else if (this.seeking === "starved") {
      const enough = Math.min(upcoming.length, Math.ceil(RESUME * this.reel.fps * Math.abs(speed)));
      if (this.ahead.fetched < enough) return;
      this.seeking = null;
      this.clock.release();
    } else if (playing && upcoming.length > 0 && this.ahead.fetched === 0) {
      this.seeking = "starved";
      this.counts.stalls += 1;
      this.clock.hold();
    }
  }

  /** What the camera sees now of the frame that is shown; the newest view wins. */
  private repack(look: Look): void {
    const made = this.shown;
    if (!made || this.packing || made.look === look.number || made.mode !== look.mode) return;
    if (made.life !== this.pool.life(made.worker)) return;
    this.packing = true;
    const number = look.number;
    this.pool.pack(made.worker, made.key, viewOf(look)).then((done) => {
      const fresh: MadeFrame = { ...made, packed: done.packed, look: number };
      if (this.made.get(made.frame) === made) this.made.set(made.frame, fresh);
    }).catch(() => undefined).finally(() => {
      this.packing = false;
      this.onReady();
    });
  }

  private drop(made: MadeFrame): void {
    if (made.life === this.pool.life(made.worker)) this.pool.drop(made.worker, [made.key]);
  }
  /** Keeps what is near within a bound of memory. */
  private trim(frame: number, upcoming: readonly number[]): void {
    if (this.made.size <= MAKE_AHEAD + 2) return;
    const near = new Map<number, number>([frame, ...upcoming].map((f, i) => [f, i]));
    const far = (f: number) => near.get(f) ?? 1000 + Math.abs(f - frame);
    const ordered = [...this.made.values()].sort((a, b) => far(a.frame) - far(b.frame));
    let bytes = 0;
    ordered.forEach((made, i) => {
      bytes += made.facts.memory + made.packed.instances.byteLength + made.packed.indices.byteLength;
      if (i <= MAKE_AHEAD + 1 || made === this.shown || (bytes <= FRAME_BYTES && i < 40)) return;
      this.drop(made);
      this.made.delete(made.frame);
    });
  }
  /** While pictures come too slowly. Of an octree, only what is as coarse as asked is packed, but of video all points are. */
  private dropFiner(): void {
    if (this.reel.groupFrames === 0) return;
    for (const made of this.made.values()) {
      if (made.level <= this.level || made === this.shown) continue;
      this.drop(made);
      this.made.delete(made.frame);
    }
  }
  private clear(): void {
    for (const made of this.made.values()) this.drop(made);
    this.made.clear();
    this.shown = null;
  }

  /** Parts of the reel that could be played without the link, in microseconds. */
  buffered(): { from: number; to: number; whole: boolean }[] {
    const parts: { from: number; to: number; whole: boolean }[] = [];
    for (let f = 0; f < this.reel.frames; ++f) {
      const have = this.store.have(f);
      if (have === 0) continue;
      const whole = have >= this.store.end(f, this.wanted);
      const from = this.reel.timesUs[f]!, to = this.reel.timesUs[f + 1] ?? this.reel.durationUs;
      const last = parts[parts.length - 1];
      if (last && last.to === from && last.whole === whole) last.to = to;
      else parts.push({ from, to, whole });
    }
    return parts;
  }
}
