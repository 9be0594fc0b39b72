// The sound of the live streams of a scene.
import type { Soundtrack } from "../sound";
import { Output } from "./output";
import { StreamSound } from "./stream_sound";

const canDecode = () => typeof AudioContext === "function" &&
  (typeof AudioDecoder === "function" || new Audio().canPlayType('audio/ogg; codecs="opus"') !== "");

export class LiveSounds implements Soundtrack {
  readonly problem = canDecode() ? null : "this browser cannot decode Opus, so live streams are silent";
  private readonly output = new Output();
  private readonly streams: StreamSound[] = [];

  /** `beganMuted`: servers are asked for sound only once it is not muted any more. */
  constructor(private readonly beganMuted: boolean) {}
  free(): void {
    for (const stream of this.streams) stream.free();
    this.output.free();
  }

  makeStream(): StreamSound {
    const made = new StreamSound(this.output, !this.beganMuted && !this.problem);
    this.streams.push(made);
    return made;
  }
  /** Streams do not say that they have sound before they send some. Whoever has muted it must be able to ask for it. */
  get isThere(): boolean { return this.beganMuted || this.problem !== null || this.streams.some((stream) => stream.hasBegun); }

  setVolume(volume: number, muted: boolean): void {
    this.output.setVolume(muted ? 0 : volume);
    if (muted || this.problem) return;
    for (const stream of this.streams.filter(({ isWanted }) => !isWanted)) {
      stream.isWanted = true;
      stream.onWanted();
    }
  }
}
