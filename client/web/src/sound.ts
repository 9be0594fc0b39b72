// The sound of a reel: an <audio> that follows the page's clock.
import { Clock } from "./clock";
import { hasActed } from "./gesture";

// How far sound may be from the clock, in seconds: what is farther off jumps, and what is a little off is played a
// little faster or slower.
const JUMP = 0.2, NEAR = 0.008;

/** What the controls have to know of sound. */
export interface Soundtrack {
  /** Why it is not heard, in one line for people; null while it is, or would be if it were played. */
  readonly problem: string | null;
  setVolume(volume: number, muted: boolean): void;
  free(): void;
}

export class Sound implements Soundtrack {
  problem: string | null = null;
  private readonly audio = new Audio();
  private made = "";
  /** Until the user has done something on the page. */
  private isBlocked = false;

  /** `address`: of the file. It may take a while to be known. */
  constructor(address: Promise<string>) {
    const { audio } = this;
    audio.preload = "auto";
    audio.onerror = () => (this.problem ??= "the sound cannot be played");
    if (!audio.canPlayType('audio/ogg; codecs="opus"')) {
      this.problem = "this browser cannot play Opus in Ogg, so there is no sound";
      return;
    }
    address.then((url) => {
      this.made = url;
      audio.src = url;
    }, (error: Error) => (this.problem = error.message));
  }
  free(): void {
    this.audio.onerror = null;
    this.audio.pause();
    this.audio.removeAttribute("src");
    if (this.made.startsWith("blob:")) URL.revokeObjectURL(this.made);
  }

  setVolume(volume: number, muted: boolean): void {
    this.audio.volume = volume;
    this.audio.muted = muted;
  }

  /** How far it is ahead of the clock, in seconds; NaN while it is silent. */
  ahead(clock: Clock): number {
    return this.audio.paused ? NaN : this.audio.currentTime - clock.read().positionUs / 1e6;
  }

  /** To be called again and again. */
  follow(clock: Clock): void {
    const { audio } = this, { playing, held, speed } = clock.state(), { positionUs, ended } = clock.read();
    const at = positionUs / 1e6;
    if (this.isBlocked && hasActed()) this.isBlocked = false;
    // Until its length is known, nothing can be sought.
    const isHeard = playing && !held && speed > 0 && !ended && at < audio.duration && !this.isBlocked;
    if (!isHeard) {
      if (!audio.paused) audio.pause();
      return;
    }
    const ahead = audio.currentTime - at;
    if (Math.abs(ahead) > JUMP && !audio.seeking) audio.currentTime = at;
    const correction = Math.abs(ahead) > NEAR ? Math.max(-0.1, Math.min(0.1, 2 * ahead)) : 0;
    const rate = speed * (1 - correction);
    if (audio.playbackRate !== rate) audio.playbackRate = rate;
    if (audio.paused) audio.play().catch((error: Error) => { if (error.name === "NotAllowedError") this.isBlocked = true; });
  }
}
