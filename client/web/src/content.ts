// What a player has open: a reel or live streams, and what fetches and decodes them.
import { ScalarRange } from "./colors";
import { WORKERS } from "./device";
import { checkToken, Fetcher } from "./fetching";
import { LivePlayback } from "./live";
import { LiveSounds } from "./live_sound/live_sounds";
import { load, loadWhole } from "./loading";
import { Box, FrameFacts, isEmpty, Module, Vec3, viewBox } from "./module";
import { MadeFrame, ReelPlayback } from "./playback";
import { Assets, Pool } from "./pool";
import { Reel } from "./reel";
import { Sound, Soundtrack } from "./sound";
import { whyNoVideo } from "./video_decoder";

/** A link may name any number of live streams, and each takes a connection and memory. */
const MOST_STREAMS = 16;

export interface ContentOptions {
  loop: boolean;
  startUs: number;
  /** Where live streams stand, one after another; (0, 0, 0) for those not given. */
  places: readonly Vec3[];
}
/** What a player has to say besides. */
export interface PlayerState {
  /** Sound that is not heard is not fetched from live streams. */
  muted: boolean;
}

const moved = (box: Box, way: readonly number[]): Box =>
  ({ min: box.min.map((v, i) => v + way[i]!) as Vec3, max: box.max.map((v, i) => v + way[i]!) as Vec3 });

/** Null if all boxes are missing or empty. */
function enclosing(boxes: readonly (Box | null)[]): Box | null {
  let all: Box | null = null;
  for (const box of boxes) {
    if (!box || isEmpty(box)) continue;
    all = all ? { min: all.min.map((v, i) => Math.min(v, box.min[i]!)) as Vec3,
                  max: all.max.map((v, i) => Math.max(v, box.max[i]!)) as Vec3 } : box;
  }
  return all;
}

function addressOf(source: string): URL {
  try {
    const url = new URL(source, document.baseURI);
    if (/^(https?|wss?):$/.test(url.protocol)) return url;
  } catch {
    // The message below says more than the browser's.
  }
  throw new Error(`${source}: is not an address of http, https, ws or wss`);
}

export class Content {
  reel: ReelPlayback | null = null;
  live: LivePlayback[] = [];
  /** Of a reel. */
  sound: Sound | null = null;
  private liveSounds: LiveSounds | null = null;
  /** Of each part, the frame by which a first view of it is chosen. */
  private readonly first: FrameFacts[] = [];
  /** By the module that decodes. */
  private readonly pools = new Map<WebAssembly.Module, Pool>();
  private tooMany: string | null = null;

  private constructor(private readonly base: URL, readonly module: Module, private readonly assets: Assets,
                      private readonly fetcher: Fetcher | null, private readonly signal: AbortSignal) {}

  /**
   * `sources`: the address of a reel.json, or those of live streams. `base`: where the player's files are.
   * Calls `changed` when there may be something else to show, and `waits` when the link is the reason that nothing is.
   */
  static async open(base: URL, sources: readonly string[], token: string | null, options: ContentOptions & PlayerState,
                    changed: () => void, waits: (why: string | null) => void, signal: AbortSignal): Promise<Content> {
    const urls = sources.map(addressOf);
    checkToken(token);
    const isLive = urls.every((url) => /^wss?:$/.test(url.protocol));
    const fetcher: Fetcher | null = isLive ? null : new Fetcher(urls[0]!, token, () => waits(fetcher!.trouble));
    const [manifest, { assets, module }] = await Promise.all([fetcher?.manifest(signal), load(base)]);
    signal.throwIfAborted();
    const content = new Content(base, module, assets, fetcher, signal);
    try {
      if (manifest && fetcher) await content.openReel(Reel.read(module, manifest), fetcher, options, changed);
      else {
        const sounds = (content.liveSounds = new LiveSounds(options.muted));
        if (urls.length > MOST_STREAMS) content.tooMany = `only the first ${MOST_STREAMS} of ${urls.length} live streams are shown`;
        content.live = urls.slice(0, MOST_STREAMS).map((url, i) => new LivePlayback(
          url.href, options.places[i] ?? [0, 0, 0], token, module, (isDraco) => content.poolFor(isDraco), sounds.makeStream(), changed));
      }
      return content;
    } catch (error) {
      content.free();
      throw error;
    }
  }

  private async openReel(reel: Reel, fetcher: Fetcher, options: ContentOptions, changed: () => void): Promise<void> {
    try {
      if (reel.frames === 0) throw new Error("this reel has no frames");
      const pool = await this.poolFor(reel.text("codec") === "draco");
      let tables = 0;
      if (reel.tablesBytes > 0) {
        const bytes = await fetcher.file(reel.text("tablesPath"), reel.tablesBytes, this.signal);
        tables = pool.addTables(bytes, reel.text("tablesChecksum"));
      }
      const noVideo = reel.groupFrames > 0 ? await whyNoVideo() : null;
      this.signal.throwIfAborted();
      this.reel = new ReelPlayback(reel, pool, fetcher, tables, options.loop, changed);
      this.reel.noVideo = noVideo;
      this.reel.clock.seek(options.startUs);
      if (reel.audioBytes > 0) this.sound = new Sound(fetcher.address(reel.text("audioPath"), reel.audioBytes, this.signal));
    } finally {
      if (!this.reel) reel.free();
    }
  }
  private async poolFor(isDraco: boolean): Promise<Pool> {
    const compiled = isDraco ? await loadWhole(this.base) : this.assets.compiled;
    this.signal.throwIfAborted();
    const pool = this.pools.get(compiled) ?? new Pool({ ...this.assets, compiled }, WORKERS);
    this.pools.set(compiled, pool);
    return pool;
  }

  free(): void {
    this.sound?.free();
    this.reel?.free();
    for (const live of this.live) live.free();
    this.liveSounds?.free();
    for (const pool of this.pools.values()) pool.free();
  }

  /** Null if nothing that is open is known to have sound. */
  get soundtrack(): Soundtrack | null { return this.sound ?? (this.liveSounds?.isThere ? this.liveSounds : null); }
  setVolume(volume: number, muted: boolean): void { (this.sound ?? this.liveSounds)?.setVolume(volume, muted); }

  get up(): number | undefined { return this.reel?.reel.up ?? this.live[0]?.up; }
  private get parts(): { bounds: Box | null; place: Vec3; shown: MadeFrame | null }[] {
    const { reel } = this;
    return reel ? [{ bounds: reel.reel.bounds, place: [0, 0, 0], shown: reel.shown }] : this.live;
  }
  /** Notes where the points are of what is shown; returns whether that changes viewBounds. */
  noteShown(): boolean {
    let changed = false;
    this.parts.forEach(({ shown }, i) => {
      const first = this.first[i];
      if (!shown || (first && !(first.roughBoxes && shown.facts.level > first.level))) return;
      this.first[i] = shown.facts;
      changed = true;
    });
    return changed;
  }
  /** Of all frames and streams so far; null if nothing is known yet. */
  bounds(): Box | null { return enclosing(this.parts.map((part) => part.bounds)); }
  /** The same without stray points of the first frame: what a first view frames. */
  viewBounds(): Box | null {
    return enclosing(this.parts.map(({ bounds, place }, i) => {
      const first = this.first[i];
      if (!bounds || !first) return bounds;
      const box = viewBox(this.module, moved(bounds, place.map((v) => -v)), first.boxes);
      return moved(box, place);
    }));
  }
  /** Of all parts, without repetition of names. */
  get scalars(): ScalarRange[] {
    const all = this.reel ? this.reel.reel.scalars : this.live.flatMap((live) => live.scalars);
    return all.filter(({ name }, i) => all.findIndex((other) => other.name === name) === i);
  }
  /** The frames to draw. */
  shown(): MadeFrame[] {
    const shown = this.reel ? [this.reel.shown] : this.live.map((live) => live.shown);
    return shown.filter((made): made is MadeFrame => made !== null);
  }
  get traffic(): { bytes: number; requests: number } {
    return { bytes: this.fetcher?.total ?? 0, requests: this.fetcher?.requests ?? 0 };
  }
  get memory(): number { return [...this.pools.values()].reduce((sum, pool) => sum + pool.memory, 0); }
  /** What is wrong at the moment, in one line, or null. */
  get trouble(): string | null {
    const first = (lines: (string | null)[]) => lines.find((line) => line) ?? null;
    const trouble = first([...[...this.pools.values()].map((pool) => pool.trouble), this.fetcher?.trouble ?? null,
                  ...this.live.map((live) => live.error ?? live.sound.error), this.reel?.error ?? null]);
    const coarse = this.reel?.noVideo ? `only a coarse picture: ${this.reel.noVideo}` : null;
    return [this.tooMany, coarse, trouble].filter((line) => line).join("; ") || null;
  }
}
