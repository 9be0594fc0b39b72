// The workers: who does which job, and what is done about one that traps or hangs.
import { WORKERS } from "./device";
import { Done, FromWorker, ToWorker, VideoPlace } from "./messages";
import { Preparation } from "./view";

/** The browser does not decode video; the message says why. */
export class UndecodableVideo extends Error {}
/** The job was lost through no fault of its own, and may be given to a worker again. */
export class LostJob extends Error {}

/** What all workers are given. */
export interface Assets {
  compiled: WebAssembly.Module;
  tables: Uint8Array;
  workers: Workers;
}

/** Starts workers. Those of the first pool start at once, while the module is still being loaded. */
export class Workers {
  private readonly started: Worker[];

  constructor(private readonly script: URL) { this.started = Array.from({ length: WORKERS }, () => this.start()); }

  free(): void { for (const worker of this.started) worker.terminate(); }
  take(): Worker { return this.started.pop() ?? this.start(); }
  private start(): Worker { return new Worker(this.script, { type: "module" }); }
}

/**
 * A job hangs if it takes so many times as long as the longest before it, but at least and at most so many milliseconds.
 * Until a job is done nothing is known; dense frames on a slow phone take a few seconds. Nor do other jobs say how long
 * the browser's decoder of video takes, which has the machine to share.
 */
const HANGS = { times: 20, least: 3000, most: 15_000 };

interface Waiting {
  isVideo: boolean;
  resolve(done: Done): void;
  reject(error: Error): void;
}

class Hand {
  worker!: Worker;
  jobs = new Map<number, Waiting>();
  timer = 0;
  memory = 0;
  /** Grows when the worker is replaced and has forgotten all frames. */
  life = 0;
}

/** What a frame is made of, as Prepare has it. */
export interface FrameChunks {
  bytes: Uint8Array;
  sizes: Uint32Array;
  video: VideoPlace | null;
}

export class Pool {
  private readonly hands: Hand[] = [];
  private readonly tables: ToWorker[] = [];
  private nextJob = 1;
  private nextTables = 1;
  /** Milliseconds that the longest job took. */
  private longest = Infinity;
  /** Why some worker does not work, or null. */
  trouble: string | null = null;

  /** `count`: how many workers. */
  constructor(private readonly assets: Assets, count: number) {
    for (let i = 0; i < count; ++i) {
      const hand = new Hand();
      this.hands.push(hand);
      this.start(hand);
    }
  }

  get size(): number { return this.hands.length; }
  get memory(): number { return this.hands.reduce((sum, hand) => sum + hand.memory, 0); }
  /** The frames that a worker was given before are lost if this has changed. */
  life(worker: number): number { return this.hands[worker]!.life; }
  load(worker: number): number { return this.hands[worker]!.jobs.size; }
  /** The worker with the fewest jobs. */
  idlest(): number {
    let best = 0;
    for (let i = 1; i < this.hands.length; ++i) if (this.load(i) < this.load(best)) best = i;
    return best;
  }

  /** Gives all workers a reel's own tables. Returns the number that jobs name them by. */
  addTables(bytes: Uint8Array, checksum: string): number {
    const message: ToWorker = { type: "tables", tables: this.nextTables, bytes, checksum };
    this.tables.push(message);
    for (const hand of this.hands) hand.worker.postMessage(message);
    return this.nextTables++;
  }

  prepare(worker: number, key: number, chunks: FrameChunks, tables: number, how: Preparation, view: Float64Array): Promise<Done> {
    const { bytes, sizes, video } = chunks;
    return this.ask(worker, { type: "prepare", job: this.nextJob++, key, bytes, sizes, video, tables, ...how, view },
                    [bytes.buffer]);
  }
  pack(worker: number, key: number, view: Float64Array): Promise<Done> {
    return this.ask(worker, { type: "pack", job: this.nextJob++, key, view });
  }
  drop(worker: number, keys: number[]): void {
    this.hands[worker]!.worker.postMessage({ type: "drop", keys } as ToWorker);
  }
  free(): void {
    for (const hand of this.hands) {
      clearTimeout(hand.timer);
      hand.worker.terminate();
      this.fail(hand, "the player was closed");
    }
  }

  private ask(worker: number, message: ToWorker & { job: number }, transfer: Transferable[] = []): Promise<Done> {
    const hand = this.hands[worker]!;
    return new Promise((resolve, reject) => {
      hand.jobs.set(message.job, { isVideo: message.type === "prepare" && message.video !== null, resolve, reject });
      hand.worker.postMessage(message, transfer);
      // Jobs that wait behind another must not give that one more time.
      if (hand.jobs.size === 1) this.watch(hand);
    });
  }

  private start(hand: Hand): void {
    const worker = this.assets.workers.take();
    hand.worker = worker;
    worker.postMessage({ type: "open", compiled: this.assets.compiled, tables: this.assets.tables } as ToWorker);
    for (const message of this.tables) worker.postMessage(message);
    worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      if (data.type === "opened") this.trouble = null;
      else if (data.type === "failed" && data.job < 0) this.trouble = data.message;
      else this.answered(hand, data);
    };
    worker.onerror = (event) => {
      event.preventDefault();
      this.trouble = "a worker of the page cannot be started";
      this.fail(hand, this.trouble);
    };
  }

  private answered(hand: Hand, data: Exclude<FromWorker, { type: "opened" }>): void {
    const waiting = hand.jobs.get(data.job);
    hand.jobs.delete(data.job);
    this.watch(hand);
    if (data.type === "done") {
      hand.memory = data.memory;
      const took = data.times.prepareMs + data.times.packMs;
      if (!waiting?.isVideo) this.longest = this.longest === Infinity ? took : Math.max(this.longest, took);
      waiting?.resolve(data);
      return;
    }
    waiting?.reject(data.noVideo ? new UndecodableVideo(data.message) : new Error(data.trapped ? "the decoder failed" : data.message));
    if (data.trapped) this.replace(hand);
  }

  private watch(hand: Hand): void {
    clearTimeout(hand.timer);
    const [first] = hand.jobs.values();
    if (!first) return;
    const expected = first.isVideo ? Infinity : HANGS.times * this.longest;
    const limit = Math.min(Math.max(expected, HANGS.least), HANGS.most);
    hand.timer = window.setTimeout(() => this.hangs(hand), limit);
  }
  private hangs(hand: Hand): void {
    // Jobs are done in their order: the first one hangs.
    const [job, waiting] = hand.jobs.entries().next().value as [number, Waiting];
    hand.jobs.delete(job);
    waiting.reject(new Error("the decoder does not come to an end"));
    this.replace(hand);
  }
  private replace(hand: Hand): void {
    clearTimeout(hand.timer);
    hand.worker.terminate();
    hand.life += 1;
    hand.memory = 0;
    this.start(hand);
    this.fail(hand, "the worker was replaced");
  }
  private fail(hand: Hand, why: string): void {
    const jobs = [...hand.jobs.values()];
    hand.jobs.clear();
    for (const job of jobs) job.reject(new LostJob(why));
  }
}
