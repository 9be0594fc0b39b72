// Packets of Opus to samples, by what the browser has for it.
import { oggOf } from "./ogg";

export const RATE = 48_000;
/** One packet of Opus, as module.h has it. */
export interface Packet {
  number: number;
  /** Unix time of the first sample, by the publisher's clock. */
  captureMs: number;
  /** Of each channel, at RATE. */
  samples: number;
  packet: Uint8Array;
}
export type OnSamples = (of: Packet, left: Float32Array, right: Float32Array) => void;
export interface OpusDecoder {
  /** Packets in their order. What comes too fast is left out. */
  decode(packet: Packet): void;
  free(): void;
}

/** Packets that wait: two seconds of them. */
const MOST_WAITING = 100;
/** A decoder is too slow if a packet waits for so many milliseconds. */
const SLOW = 500;

/**
 * Where the page came over HTTPS or from this machine; elsewhere browsers have no WebCodecs. Chromium decodes no more than a
 * packet in each turn of the page, which is too slow where drawing takes long.
 */
class WebCodecsDecoder implements OpusDecoder {
  private readonly waiting: { packet: Packet; since: number }[] = [];
  private readonly decoder: AudioDecoder;

  constructor(onSamples: OnSamples, onError: () => void, private readonly onSlow: () => void) {
    this.decoder = new AudioDecoder({
      // The times of what comes out are not those of what went in where packets are missing. Each packet gives one output.
      output: (data) => {
        const of = this.waiting.shift(), frames = data.numberOfFrames;
        const planes = [0, data.numberOfChannels - 1].map((planeIndex) => {
          const plane = new Float32Array(frames);
          data.copyTo(plane, { planeIndex, format: "f32-planar" });
          return plane;
        });
        data.close();
        if (of) onSamples(of.packet, planes[0]!, planes[1]!);
      },
      error: onError,
    });
    this.decoder.configure({ codec: "opus", sampleRate: RATE, numberOfChannels: 2 });
  }
  decode(packet: Packet): void {
    if (this.decoder.state !== "configured") return;
    const since = performance.now();
    if (this.waiting[0] && since - this.waiting[0].since > SLOW) return this.onSlow();
    if (this.waiting.length >= MOST_WAITING) return;
    this.waiting.push({ packet, since });
    this.decoder.decode(new EncodedAudioChunk({
      type: "key", timestamp: Math.round(1000 * packet.captureMs), duration: Math.round((1e6 * packet.samples) / RATE), data: packet.packet,
    }));
  }
  free(): void { if (this.decoder.state !== "closed") this.decoder.close(); }
}

/** Decodes a tenth of a second at a time, as a file of its own, behind packets that were decoded before: RFC 7845, 4.6. */
class FileDecoder implements OpusDecoder {
  private static readonly PART = RATE / 10;
  private static readonly WARM_UP = 0.08 * RATE;
  private readonly waiting: Packet[] = [];
  private before: Packet[] = [];
  private busy = false;
  private isFree = false;

  constructor(private readonly context: BaseAudioContext, private readonly onSamples: OnSamples, private readonly onError: () => void) {}
  free(): void { this.isFree = true; }

  decode(packet: Packet): void {
    if (this.waiting.length >= MOST_WAITING) return;
    this.waiting.push(packet);
    this.next();
  }
  private next(): void {
    const { before, waiting } = this, count = (some: readonly Packet[]) => some.reduce((sum, { samples }) => sum + samples, 0);
    if (this.busy || this.isFree || count(waiting) < FileDecoder.PART) return;
    this.busy = true;
    const part = waiting.splice(0), all = [...before, ...part];
    this.context.decodeAudioData(oggOf(all).buffer).then((sound) => {
      if (this.isFree) return;
      const planes = [0, sound.numberOfChannels - 1].map((channel) => sound.getChannelData(channel));
      let at = count(before);
      for (const packet of part) {
        const [left, right] = planes.map((plane) => plane.slice(at, at + packet.samples));
        this.onSamples(packet, left!, right!);
        at += packet.samples;
      }
      while (all.length > 1 && count(all.slice(1)) >= FileDecoder.WARM_UP) all.shift();
      this.before = all;
    }, () => {
      this.before = [];
      if (!this.isFree) this.onError();
    }).finally(() => {
      this.busy = false;
      this.next();
    });
  }
}

/**
 * `onError`: nothing that was given can be decoded any more; make another decoder. `onSlow`: make one that decodes more packets
 * at a time.
 */
export function makeDecoder(context: BaseAudioContext, onSamples: OnSamples, onError: () => void, onSlow: (() => void) | null): OpusDecoder {
  if (onSlow && typeof AudioDecoder === "function") return new WebCodecsDecoder(onSamples, onError, onSlow);
  return new FileDecoder(context, onSamples, onError);
}
