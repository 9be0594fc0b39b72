// Where the sound of the live streams of a scene is mixed and heard.
import { hasActed } from "../gesture";
import { RATE } from "./decoder";

/** What the user hears is timed to this share of what the browser says last; before that, to the rest. */
const NEWEST = 0.05;
const JUMP_MS = 50;
const now = () => performance.timeOrigin + performance.now();

export class Output {
  /** Null before sound has come. */
  private made: { context: AudioContext; gain: GainNode } | null = null;
  private volume = 1;
  /** Unix time in milliseconds of the context's time 0, as it is heard. */
  private begin: number | null = null;
  private readonly wake = () => this.resume();

  /** What sound is played by, and to where. */
  get sink(): { context: AudioContext; gain: GainNode } {
    if (this.made) return this.made;
    const context = new AudioContext({ sampleRate: RATE, latencyHint: "interactive" }), gain = context.createGain();
    gain.gain.value = this.volume;
    gain.connect(context.destination);
    // Some browsers begin only inside the handler of a gesture.
    for (const gesture of ["pointerup", "keydown"]) document.addEventListener(gesture, this.wake, true);
    return (this.made = { context, gain });
  }
  free(): void {
    for (const gesture of ["pointerup", "keydown"]) document.removeEventListener(gesture, this.wake, true);
    this.made?.context.close().catch(() => undefined);
    this.made = null;
  }
  private resume(): void { this.made?.context.resume().catch(() => undefined); }

  setVolume(volume: number): void {
    this.volume = volume;
    if (this.made) this.made.gain.gain.value = volume;
  }

  get isAudible(): boolean { return this.volume > 0; }
  /** Whether anything is played: not before the user's first gesture. */
  get runs(): boolean {
    const { context } = this.sink;
    if (context.state === "running") return true;
    this.begin = null;
    if (hasActed()) this.resume();
    return false;
  }
  /** Unix time in milliseconds at which what is played at this time of the context is heard. */
  heardAt(seconds: number): number {
    const { context } = this.sink, { contextTime, performanceTime } = context.getOutputTimestamp?.() ?? {};
    // At first, and in some browsers, both are 0.
    const begin = contextTime && performanceTime
      ? performance.timeOrigin + performanceTime - 1000 * contextTime
      : now() - 1000 * (context.currentTime - (context.outputLatency || context.baseLatency || 0));
    const isNew = this.begin === null || Math.abs(begin - this.begin) > JUMP_MS;
    this.begin = isNew ? begin : this.begin! + NEWEST * (begin - this.begin!);
    return this.begin + 1000 * seconds;
  }
}
