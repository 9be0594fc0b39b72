// The samples of the last seconds, by their number.
import { RATE } from "./decoder";

const KEPT = 8 * RATE;
/** Packets that begin closer than this to the end of the one before go on from there. */
const CLOSE = RATE / 50;
/** The longest gap that is filled with silence. After another, or a step back, all begins anew. */
const LONGEST = 4 * RATE;

export class Ring {
  private readonly planes = [new Float32Array(KEPT), new Float32Array(KEPT)] as const;
  /** Behind the newest sample. */
  end = 0;

  /** `first`: the number of the first sample, not negative. Returns whether all begins anew. */
  put(first: number, left: Float32Array, right: Float32Array): boolean {
    const isNew = Math.abs(first - this.end) > LONGEST;
    if (isNew) {
      for (const plane of this.planes) plane.fill(0);
      this.end = first;
    }
    if (Math.abs(first - this.end) < CLOSE) first = this.end;
    for (; this.end < first; ++this.end) for (const plane of this.planes) plane[this.end % KEPT] = 0;
    for (let i = this.end - first; i < left.length; ++i, ++this.end) {
      // Samples may be hostile.
      this.planes[0][this.end % KEPT] = Math.max(-1, Math.min(1, left[i]! || 0));
      this.planes[1][this.end % KEPT] = Math.max(-1, Math.min(1, right[i]! || 0));
    }
    return isNew;
  }

  private sample(channel: 0 | 1, n: number): number {
    return n >= 0 && n < this.end && n >= this.end - KEPT ? this.planes[channel][n % KEPT]! : 0;
  }
  /** Samples at `from`, `from + pace` and so on, between which it interpolates (Catmull-Rom). */
  read(channel: 0 | 1, from: number, pace: number, to: Float32Array): void {
    for (let i = 0; i < to.length; ++i) {
      const at = from + i * pace, n = Math.floor(at), t = at - n;
      const b = this.sample(channel, n);
      if (t === 0) {
        to[i] = b;
        continue;
      }
      const a = this.sample(channel, n - 1), c = this.sample(channel, n + 1), d = this.sample(channel, n + 2);
      to[i] = b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
    }
  }
}
