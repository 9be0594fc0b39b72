// The browser's decoder of AV1.

/** The frame cannot be decoded. */
export class VideoError extends Error {}
/** None can: the browser does not give what is needed. */
export class NoVideo extends VideoError {}
/** A decoder has ended; a new one may decode it. */
export class DecoderEnded extends VideoError {}

/** Of pictures in 4:2:0. */
export const DEPTH_BITS = 10, COLOR_BITS = 8;
type Bits = typeof DEPTH_BITS | typeof COLOR_BITS;
const FORMATS: Record<Bits, string> = { [DEPTH_BITS]: "I420P10", [COLOR_BITS]: "I420" };

/** Decoders in hardware answer late and in formats of their own. */
const configOf = (bits: Bits, width: number, height: number): VideoConfig => ({
  codec: `av01.0.13M.${String(bits).padStart(2, "0")}`, codedWidth: width, codedHeight: height,
  hardwareAcceleration: "prefer-software", optimizeForLatency: true,
});

/** Why this browser does not decode the video of a reel, or null. */
export async function whyNoVideo(): Promise<string | null> {
  if (typeof VideoDecoder === "undefined")
    return isSecureContext ? "this browser has no decoder of video for pages (WebCodecs); Chrome, Edge and Firefox have one"
                           : "browsers decode video only for pages from https:// or localhost";
  for (const bits of [DEPTH_BITS, COLOR_BITS] as const) {
    const { supported } = await VideoDecoder.isConfigSupported(configOf(bits, 2048, 2048)).catch(() => ({ supported: false }));
    if (!supported) return `this browser does not decode AV1 of ${bits} bits in software; Chrome, Edge and Firefox do`;
  }
  return null;
}

/** A decoder that has given nothing for so long, twice, is asked whether it has anything to give. Longer, if it had. */
let silenceMs = 600;
const LONGEST_SILENCE_MS = 10_000;

interface Waiting {
  timestamp: number;
  resolve(frame: VideoFrameLike): void;
  reject(error: Error): void;
}

/** One video: each chunk gives one picture. */
export class Av1Decoder {
  private readonly decoder: VideoDecoder;
  private waiting: Waiting[] = [];
  private timer = 0;
  private hasEnded = false;

  constructor(private readonly bits: Bits, private readonly width: number, private readonly height: number) {
    this.decoder = new VideoDecoder({
      output: (frame) => this.take(frame),
      error: () => this.fail("the video is damaged"),
    });
    this.decoder.configure(configOf(bits, width, height));
  }

  /** The first chunk is a key. The picture is the caller's to close. */
  decode(number: number, data: Uint8Array): Promise<VideoFrameLike> {
    if (this.hasEnded) return Promise.reject(new DecoderEnded("the decoder has ended"));
    return new Promise((resolve, reject) => {
      this.waiting.push({ timestamp: number, resolve, reject });
      this.watch();
      try {
        this.decoder.decode(new EncodedVideoChunk({ type: number === 0 ? "key" : "delta", timestamp: number, data }));
      } catch {
        this.fail("the video is damaged");
      }
    });
  }
  /** Copies a picture's planes, without gaps, as they follow each other. */
  async copy(frame: VideoFrameLike, to: Uint8Array): Promise<void> {
    const { bits, width, height } = this;
    if (frame.format !== FORMATS[bits])
      throw new NoVideo(`this browser decodes AV1 of ${bits} bits in a format that it does not show (${frame.format})`);
    if (frame.codedWidth < width || frame.codedHeight < height) throw new VideoError("the video's pictures have another size");
    const bytes = bits > 8 ? 2 : 1, luma = width * height * bytes, stride = width * bytes;
    await frame.copyTo(to, {
      rect: { x: 0, y: 0, width, height },
      layout: [{ offset: 0, stride }, { offset: luma, stride: stride / 2 }, { offset: luma * 5 / 4, stride: stride / 2 }],
    });
  }
  close(): void {
    if (this.decoder.state !== "closed") this.decoder.close();
    this.fail("the decoder was closed");
  }

  private take(frame: VideoFrameLike): void {
    // A chunk before it that gave no picture gives none any more.
    while (this.waiting[0] && this.waiting[0].timestamp < frame.timestamp)
      this.waiting.shift()!.reject(new VideoError("a picture of the video is missing"));
    const waiting = this.waiting.shift();
    if (waiting) waiting.resolve(frame);
    else frame.close();
    this.watch();
  }
  /** A chunk without a picture is not an error for the decoder, and a busy machine is slow. */
  private watch(rounds = 2): void {
    clearTimeout(this.timer);
    if (this.waiting.length === 0 || this.hasEnded) return;
    this.timer = setTimeout(() => (rounds > 1 ? this.watch(rounds - 1) : this.end()), silenceMs);
  }
  /** Has it give all pictures that there are, and ends it. */
  private end(): void {
    this.hasEnded = true;
    const asked = this.waiting.length;
    this.decoder.flush().then(() => {
      if (this.waiting.length < asked) silenceMs = Math.min(2 * silenceMs, LONGEST_SILENCE_MS);
      this.fail("a picture of the video is missing");
    }, () => this.fail("the video is damaged"));
  }
  private fail(why: string): void {
    clearTimeout(this.timer);
    for (const { reject } of this.waiting.splice(0)) reject(new VideoError(why));
  }
}
