// The sound of one live stream, which is heard with its pictures.
import { makeDecoder, OpusDecoder, Packet, RATE } from "./decoder";
import { Delays } from "./delays";
import type { Output } from "./output";
import { Ring } from "./ring";

/** In seconds: before what is put into the output is heard, and what is too late for it. */
const LEAD = 0.02, LATE = 0.005;
/** How far sound may be from its time, in samples: what is farther off jumps, and what is a little off is played faster or slower. */
const JUMP = 0.08 * RATE, NEAR = 0.003 * RATE;
/** By how much at most, and how much of what it is off it makes good in a second. */
const MOST_FASTER = 0.03, MADE_GOOD = 1;
/** In samples: what is put into the output at once, and how long it takes until what begins anew is as loud as it should be. */
const LEAST = RATE / 100, MOST = RATE / 2, FADE = 128;
/** Samples before and behind that an interpolation takes. */
const AROUND = 2;
/** In milliseconds: after an error, and without packets. */
const REST = 1000;
/** In milliseconds: the ring begins so long before the first packet, so that what is heard before has a number, too. */
const BEFORE = 60_000;
/** An error is over after so many packets. */
const SOUND_AGAIN = 50;

export class StreamSound {
  /** What is wrong with what comes, or null. */
  error: string | null = null;
  /** Some has come. */
  hasBegun = false;
  /** How often something had not come in time. */
  gaps = 0;
  readonly delays = new Delays();
  /** Packets are wanted now, which were not before. */
  onWanted: () => void = () => undefined;
  private decoder: OpusDecoder | null = null;
  /** Packets are to be decoded many at a time. */
  private isSlow = false;
  private restsUntil = 0;
  private good = 0;
  private last: Packet | null = null;
  private came = -Infinity;
  /** When one was put into the ring. */
  private placed = -Infinity;
  private readonly ring = new Ring();
  /** The time of sample 0 in the ring. */
  private origin = Infinity;
  /** The sample that is put into the output next; NaN: where it is time for. */
  private position = NaN;
  /** Where that is in the output: its samples count from the context's time 0. */
  private next = 0;
  private readonly playing = new Set<AudioBufferSourceNode>();

  /** `isWanted`: whether the server is to send any. */
  constructor(private readonly output: Output, public isWanted: boolean) {}
  free(): void {
    this.silence();
    this.decoder?.free();
    this.decoder = null;
  }

  /** Something came that is no packet, or cannot be decoded. */
  fail(why: string): void {
    this.error = why;
    this.good = 0;
    this.restsUntil = performance.now() + REST;
    this.decoder?.free();
    this.decoder = null;
  }
  /** What comes from now on has nothing to do with what came before. */
  restart(): void {
    this.silence();
    this.delays.clear();
    this.last = this.error = null;
  }
  /** Nothing is heard until the next packet. */
  silence(): void {
    for (const source of this.playing) source.stop();
    this.playing.clear();
    this.position = NaN;
  }

  /** `isPlayed`: else the stream is paused. */
  add(packet: Packet, isPlayed: boolean): void {
    this.hasBegun = true;
    // Numbers begin anew with a new publisher.
    if (packet.number === this.last?.number) return;
    this.last = packet;
    this.came = performance.now();
    if (!isPlayed || !this.output.runs) return this.silence();
    if (!this.decoder && performance.now() < this.restsUntil) return;
    const takesSlow = () => {
      this.isSlow = true;
      this.decoder?.free();
      this.decoder = null;
    };
    this.decoder ??= makeDecoder(this.output.sink.context, (of, left, right) => this.place(of, left, right),
                                 () => this.fail("sound: cannot be decoded"), this.isSlow ? null : takesSlow);
    this.decoder.decode(packet);
  }

  /** Whether pictures have to wait for it. */
  get isHeard(): boolean { return this.hasBegun && performance.now() - this.came < REST && this.output.isAudible && this.output.runs; }
  /** From capture to ear, in milliseconds; NaN while nothing is heard. */
  get delayMs(): number {
    if (Number.isNaN(this.position)) return NaN;
    return this.output.heardAt(this.next / this.output.sink.context.sampleRate) - this.origin - (1000 * this.position) / RATE;
  }

  private place(of: Packet, left: Float32Array, right: Float32Array): void {
    if (this.error && ++this.good >= SOUND_AGAIN) this.error = null;
    if (of.captureMs < this.origin) this.origin = of.captureMs - BEFORE;
    if (this.ring.put(Math.round((of.captureMs - this.origin) * (RATE / 1000)), left, right)) this.restart();
    // Of packets that come together, because one of them was late, that one tells how late.
    const now = performance.now();
    if (now - this.placed > (500 * of.samples) / RATE)
      this.delays.addPacket(this.output.heardAt(this.output.sink.context.currentTime + LEAD) - of.captureMs);
    this.placed = now;
    this.play();
  }

  /** Puts into the output what has come. */
  private play(): void {
    const { context, gain } = this.output.sink, { both } = this.delays, rate = context.sampleRate;
    if (both === null) return;
    const timeFor = (frame: number) => (this.output.heardAt(frame / rate) - both - this.origin) * (RATE / 1000);
    const isLate = this.next < Math.ceil((context.currentTime + LATE) * rate);
    if (isLate && !Number.isNaN(this.position)) this.gaps += 1;
    let isNew = isLate || Number.isNaN(this.position);
    if (isNew) this.next = Math.ceil((context.currentTime + LEAD) * rate);
    const off = isNew ? 0 : timeFor(this.next) - this.position;
    if (isNew || Math.abs(off) > JUMP) {
      this.position = Math.round(timeFor(this.next));
      isNew = true;
    }
    const faster = isNew || Math.abs(off) < NEAR ? 0 : Math.max(-MOST_FASTER, Math.min(MOST_FASTER, (MADE_GOOD * off) / RATE));
    const pace = (RATE / rate) * (1 + faster);
    const count = Math.min(MOST, Math.floor((this.ring.end - AROUND - this.position) / pace));
    if (count < LEAST) {
      if (isNew) this.position = NaN;
      return;
    }
    const buffer = context.createBuffer(2, count, rate), source = context.createBufferSource();
    for (const channel of [0, 1] as const) {
      const samples = buffer.getChannelData(channel);
      this.ring.read(channel, this.position, pace, samples);
      if (isNew) for (let i = 0; i < Math.min(FADE, count); ++i) samples[i]! *= i / FADE;
    }
    source.buffer = buffer;
    source.connect(gain);
    source.onended = () => {
      source.disconnect();
      this.playing.delete(source);
    };
    source.start(this.next / rate);
    this.playing.add(source);
    this.position += count * pace;
    this.next += count;
  }
}
