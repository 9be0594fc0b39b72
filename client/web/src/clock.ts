import { Module } from "./module";

export interface Reading {
  positionUs: number;
  frame: number;
  ordinal: number;
  ended: boolean;
}
export interface ClockState {
  playing: boolean;
  held: boolean;
  speed: number;
  loop: boolean;
  range: { a: number; b: number; first: number; last: number } | null;
}

/** The position of playback: client/playback/clock.h, which the module has. */
export class Clock {
  private readonly handle: number;

  constructor(private readonly module: Module, timesUs: Float64Array, durationUs: number, loop: boolean) {
    const [times] = module.put(timesUs);
    this.handle = module.made("pr_clock_new", times!, timesUs.length, durationUs, Number(loop));
  }
  free(): void { this.module.call("pr_clock_free", this.handle); }

  private get now(): number { return Math.round(performance.now() * 1000); }
  private act(name: string, ...args: number[]): void { this.module.call(name, this.handle, ...args, this.now); }

  read(): Reading {
    const r = this.module.doubles(this.module.call("pr_clock_read", this.handle, this.now), 4);
    return { positionUs: r[0]!, frame: r[1]!, ordinal: r[2]!, ended: r[3] !== 0 };
  }
  state(): ClockState {
    const s = this.module.doubles(this.module.call("pr_clock_state", this.handle), 9);
    return { playing: s[0] !== 0, held: s[1] !== 0, speed: s[2]!, loop: s[3] !== 0,
             range: s[4] !== 0 ? { a: s[5]!, b: s[6]!, first: s[7]!, last: s[8]! } : null };
  }
  frameAt(us: number): number { return this.module.call("pr_clock_frame_at", this.handle, us); }
  play(): void { this.act("pr_clock_play"); }
  pause(): void { this.act("pr_clock_pause"); }
  hold(): void { this.act("pr_clock_hold"); }
  release(): void { this.act("pr_clock_release"); }
  seek(us: number): void { this.act("pr_clock_seek", us); }
  seekBy(us: number): void { this.act("pr_clock_seek_by", us); }
  step(frames: number): void { this.act("pr_clock_step", frames); }
  setSpeed(speed: number): void { this.act("pr_clock_set_speed", speed); }
  setLoop(loop: boolean): void { this.act("pr_clock_set_loop", Number(loop)); }
  setRange(range: { a: number; b: number } | null): void {
    this.act("pr_clock_set_loop_range", range?.a ?? -1, range?.b ?? -1);
  }
}
