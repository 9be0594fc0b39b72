// A live stream: the newest frame, as soon as it has come.
import { ScalarRange } from "./colors";
import { DECODE_BYTES } from "./device";
import { refusal } from "./fetching";
import { Hold } from "./live_sound/hold";
import type { StreamSound } from "./live_sound/stream_sound";
import { Box, encode, Module, Vec3, WHOLE_FRAME } from "./module";
import { MadeFrame } from "./playback";
import { LostJob, Pool } from "./pool";
import { reelInfo, scalarsOf } from "./reel";
import { decoded } from "./sources";
import { fits, kindOf, Look, preparation, viewOf } from "./view";

const BAD = 0, HELLO = 1, END = 3;  // PrMessage
const DRACO = 2;  // PrReelInfo::codec
const SOUND = 0x31535250;  // how a packet of sound begins: PRS1
const isSound = (data: ArrayBuffer): boolean => data.byteLength >= 4 && new DataView(data).getUint32(0, true) === SOUND;
/** As PROTOCOL.md wants tokens in a subprotocol. */
const escaped = (token: string): string => encodeURIComponent(token).replace(
  /[!'()*]/g, (c) => `%${c.charCodeAt(0).toString(16).toUpperCase()}`);
/** Hosts to which the page's security policy allows no connection. The events of a WebSocket do not say so. */
const blockedHosts = new Set<string>();
document.addEventListener("securitypolicyviolation", ({ blockedURI, disposition }) => {
  if (disposition === "enforce" && /^wss?:/.test(blockedURI)) blockedHosts.add(new URL(blockedURI).host);
});
let nextKey = 0x40000000;  // reels count from 1

interface LiveFrame {
  number: number;
  captureUs: number;
  layers: number;
  bytes: Uint8Array;
  sizes: Uint32Array;
  /** How long it was held, in milliseconds. */
  held: number;
}

export class LivePlayback {
  shown: MadeFrame | null = null;
  bounds: Box | null = null;
  up = 2;
  scalars: readonly ScalarRange[] = [];
  /** What is wrong, or null. */
  error: string | null = null;
  playing = true;
  /** From capture to the picture that was seen last, if the clocks of both machines agree. */
  delayMs = 0;
  frames = 0;
  private readonly handle: number;
  private socket: WebSocket | null = null;
  private pause = 100;
  private busy = false;
  private packing = false;
  private look: Look | null = null;
  /** The frame that is shown, or being made. */
  private taken: LiveFrame | null = null;
  private again = 0;
  private closed = false;

  private pool: Pool | null = null;
  /** Of what is shown, in milliseconds: when it was captured, and how long it was held. */
  private shownAt = { capture: 0, held: 0 };
  private drawnKey = 0;
  /** Pictures wait for sound if that takes longer. */
  private readonly hold = new Hold<string | ArrayBuffer>((data) => this.take(data));

  /** `poolFor`: who decodes a stream is known when it says hello. */
  constructor(readonly url: string, readonly place: Vec3, private readonly token: string | null, private readonly module: Module,
              private readonly poolFor: (isDraco: boolean) => Promise<Pool>, readonly sound: StreamSound,
              private readonly onReady: () => void) {
    this.handle = module.made("pr_live_new");
    // The server learns from the address whether to send sound.
    sound.onWanted = () => this.connectAnew();
    this.connect();
  }
  free(): void {
    this.closed = true;
    clearTimeout(this.again);
    this.hold.clear();
    this.socket?.close();
    this.module.call("pr_live_free", this.handle);
  }

  update(look: Look): void {
    this.look = look;
    this.next();
    this.repack(look);
  }

  /** What is shown was drawn. Returns what is to be called when it is seen, if it was not drawn before. */
  noteDrawn(): (() => void) | null {
    const { shown, shownAt } = this;
    if (!shown || shown.key === this.drawnKey) return null;
    this.drawnKey = shown.key;
    return () => {
      this.delayMs = performance.timeOrigin + performance.now() - shownAt.capture;
      this.sound.delays.addPicture(this.delayMs, shownAt.held);
    };
  }

  private connect(): void {
    // A page cannot set headers: the token goes with the subprotocols.
    const protocols = this.token === null ? undefined : ["pointreel", `bearer.${escaped(this.token)}`];
    let socket: WebSocket;
    try {
      socket = new WebSocket(this.address, protocols);
    } catch {
      this.error = `${this.url}: no address of a live stream`;
      return;
    }
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    let hasOpened = false;
    socket.onopen = () => { hasOpened = true; };
    const isBlocked = () => blockedHosts.has(new URL(socket.url).host);
    socket.onerror = () => {
      if (!isBlocked()) return;
      this.error = `${this.url}: the security policy of this page does not allow connections to this server`;
      this.onReady();
    };
    socket.onmessage = ({ data }) => this.receive(data as string | ArrayBuffer);
    socket.onclose = (event) => {
      if (this.closed || socket !== this.socket || isBlocked()) return;
      this.forget();
      this.error = event.reason || (this.shown ? "the connection was lost" : `there is no live stream ${this.name} yet`);
      if (!hasOpened) this.askWhy();
      this.again = window.setTimeout(() => this.connect(), this.pause);
      this.pause = Math.min(2 * this.pause, 2000);
      this.onReady();
    };
  }

  /** Of the connection. */
  private forget(): void {
    this.hold.clear();
    this.sound.restart();
    this.module.call("pr_live_reconnected", this.handle);
  }
  /** To what the address is now. */
  private connectAnew(): void {
    if (!this.socket || this.socket.readyState > WebSocket.OPEN) return;
    const old = this.socket;
    this.socket = null;
    old.onmessage = null;
    old.close();
    this.forget();
    this.connect();
  }

  private get name(): string { return decoded(new URL(this.url).pathname.split("/").pop()!); }
  private get address(): string {
    if (!this.sound.isWanted) return this.url;
    return this.url + (this.url.includes("?") ? "&sound" : "?sound");
  }

  /** A page is not told why a WebSocket was refused. The stream's manifest is refused for the same reason. */
  private askWhy(): void {
    const headers = new Headers(this.token === null ? {} : { Authorization: `Bearer ${this.token}` });
    fetch(`${this.url.replace(/^ws/, "http")}/reel.json`, { headers, cache: "no-store" }).then((response) => {
      response.body?.cancel().catch(() => undefined);
      if (this.closed || this.socket?.readyState === WebSocket.OPEN || response.status !== 401) return;
      this.error = refusal(response);
      this.onReady();
    }).catch(() => undefined);
  }

  private receive(data: string | ArrayBuffer): void {
    if (this.closed) return;
    this.pause = 100;
    if (typeof data !== "string" && isSound(data)) return this.takeSound(new Uint8Array(data));
    this.hold.ms = this.sound.isHeard ? this.sound.delays.hold : 0;
    this.hold.put(data);
  }
  private takeSound(bytes: Uint8Array): void {
    const [at] = this.module.put(bytes), found = this.module.call("pr_live_sound", at!, bytes.length);
    if (found === 0) return this.sound.fail(this.module.lastError().message);
    const [number, captureUs, samples, offset] = this.module.doubles(found, 4);
    this.sound.add({ number: number!, captureMs: captureUs! / 1000, samples: samples!, packet: bytes.subarray(offset!) }, this.playing);
  }
  private take(data: string | ArrayBuffer): void {
    if (typeof data === "string") {
      const bytes = encode(data), [at] = this.module.put(bytes);
      const kind = this.module.call("pr_live_text", this.handle, at!, bytes.length);
      if (kind === BAD) this.error = this.module.lastError().message;
      if (kind === END) this.error = `${this.name}: the publisher has gone`;
      if (kind === HELLO) this.hello();
    } else {
      const bytes = new Uint8Array(data), [at] = this.module.put(bytes);
      this.module.call("pr_live_layer", this.handle, at!, bytes.length, Math.round(performance.now() * 1000));
    }
    this.next();
  }
  private hello(): void {
    this.error = null;
    const reel = this.module.call("pr_live_reel", this.handle);
    if (reel === 0) return;
    const info = reelInfo(this.module, reel);
    this.up = info[8]!;
    this.scalars = scalarsOf(this.module, reel);
    this.poolFor(info[3] === DRACO).then((pool) => {
      if (this.closed || this.pool === pool) return;
      this.pool = pool;
      this.shown = this.taken = null;
      this.next();
    }).catch((error: Error) => {
      this.error = error.message;
      this.onReady();
    });
    const [x, y, z] = this.place;
    const vec = (i: number): Vec3 => [info[i]! + x, info[i + 1]! + y, info[i + 2]! + z];
    this.bounds = { min: vec(12), max: vec(15) };
    this.onReady();
  }

  /** The newest frame that has come, once. */
  private takeNewest(): LiveFrame | null {
    const found = this.module.call("pr_live_next", this.handle, Math.round(performance.now() * 1000));
    if (found === 0) return null;
    const f = this.module.doubles(found, 7), layers = f[2]!;
    return { number: f[0]!, captureUs: f[1]!, layers, bytes: this.module.bytes(f[4]!, f[5]!).slice(),
             sizes: Uint32Array.from(this.module.ints(f[6]!, 3 * layers)), held: this.hold.held };
  }

  /** Makes what has come, or, as for another mode, what is shown once more. */
  private next(): void {
    const { look, pool, shown } = this;
    if (this.busy || !look || !pool || this.closed) return;
    const newest = this.playing ? this.takeNewest() : null;
    const frame = newest ?? (shown && !fits(shown, look) ? this.taken : null);
    if (!frame) return;
    this.taken = frame;
    const { number, captureUs, layers, sizes } = frame, worker = pool.idlest(), life = pool.life(worker);
    const how = preparation(look, WHOLE_FRAME, number, captureUs, [0, 0, 0, 1], DECODE_BYTES,
                            { scalars: this.scalars, normalsEstimated: false });
    const key = nextKey++;
    this.busy = true;
    pool.prepare(worker, key, { bytes: frame.bytes.slice(), sizes, video: null }, 0, how, viewOf(look, this.place)).then((done) => {
      const old = this.shown;
      if (old && old.life === pool.life(old.worker)) pool.drop(old.worker, [old.key]);
      this.shown = { ...kindOf(look), frame: number, worker, life, key, layers, level: WHOLE_FRAME,
                     facts: done.facts, packed: done.packed, look: look.number, times: done.times };
      this.shownAt = { capture: captureUs / 1000, held: frame.held };
      if (newest) this.frames += 1;
      else if (old && old.key === this.drawnKey) this.drawnKey = key;  // its delay is known already
    }).catch((error: Error) => {
      if (error instanceof LostJob) return;
      this.taken = null;  // it would fail again
      this.error = `frame ${number}: ${error.message}`;
    }).finally(() => {
      this.busy = false;
      this.onReady();
      if (!this.closed) this.next();
    });
  }

  private repack(look: Look): void {
    const { shown: made, pool } = this;
    if (!made || !pool || this.packing || this.busy || made.look === look.number || made.mode !== look.mode) return;
    if (made.life !== pool.life(made.worker)) return;
    this.packing = true;
    pool.pack(made.worker, made.key, viewOf(look, this.place)).then((done) => {
      if (this.shown === made) this.shown = { ...made, packed: done.packed, look: look.number };
    }).catch(() => undefined).finally(() => {
      this.packing = false;
      this.onReady();
    });
  }
}
