// How much coarser than asked pictures are drawn while they come too slowly, as client/render/draft.h decides in the
// window. A browser does not tell how long its graphics driver draws, only when it is ready for the next picture.

export interface Coarsening {
  /** How many times fewer pixels a picture has along each side. */
  reduction: number;
  /** The least size of what is drawn, in pixels of the canvas. */
  pixelSize: number;
}

/** Larger elements first, which are blended and hardly seen; fewer pixels are. */
const STEPS: readonly Coarsening[] = [
  { reduction: 1, pixelSize: 1 }, { reduction: 1, pixelSize: 1.5 }, { reduction: 1, pixelSize: 3 },
  { reduction: 2, pixelSize: 3 },
];
/** As asked. */
export const FINEST = STEPS[0]!;
const SLOW_MS = 40;
/**
 * Above this, a coarser step is taken. A slow picture counts by how slow it is, but at most this much, and a fast one takes
 * half off: one slow picture alone, as after the page was hidden, is never enough.
 */
const LATE = 4;
const SETTLES = 500;                            // ms until frames that were made before are no longer shown
const PATIENCE = 4000, MOST_PATIENCE = 64_000;  // ms without slow pictures before a finer step is tried

export class Pace {
  private step = 0;
  private slow = 0;
  private last = 0;
  private stepped = 0;
  /** When a picture was slow, or the step changed. */
  private since = 0;
  private patience = PATIENCE;
  private isTrial = false;

  /** If nothing moves there is time for everything. */
  coarsening(moves: boolean): Coarsening { return moves ? STEPS[this.step]! : FINEST; }

  /** Nothing moves, or what is to be drawn is waited for. */
  pause(): void { this.slow = this.last = 0; }

  /** Things move, and the browser is ready for another picture, at this time in milliseconds. */
  tick(now: number): void {
    const between = now - this.last, isFirst = this.last === 0;
    this.last = now;
    if (isFirst || now - this.stepped < SETTLES) return;
    const late = between > SLOW_MS;
    this.slow = late ? Math.min(this.slow + Math.min(between / SLOW_MS, LATE), 2 * LATE) : Math.max(0, this.slow - 0.5);
    if (this.slow > 0) this.since = now;
    if (this.slow > LATE && this.step < STEPS.length - 1) {
      // A finer step that soon failed is tried again after twice as long.
      if (this.isTrial) this.patience = Math.min(2 * this.patience, MOST_PATIENCE);
      this.isTrial = false;
      this.go(1, now);
    } else if (this.step > 0 && now - this.since > this.patience) {
      this.isTrial = true;
      this.go(-1, now);
    }
  }
  private go(steps: number, now: number): void {
    this.step += steps;
    this.slow = 0;
    this.since = this.stepped = now;
  }
}
