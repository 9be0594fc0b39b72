// How long after its capture a live stream is seen and heard, in milliseconds. The clocks of both machines need not agree:
// the same difference is in all of these.

/** So many pictures count, which is about a second, and so many packets, three seconds. */
const PICTURES = 15, PACKETS = 150;
/** Packets that are so much later than most are not waited for. */
const MOST_LATER = 250;
/** Pictures do not wait longer than this; sound that needs more comes after them. */
const LONGEST_HOLD = 300;

/** The newest values, sorted when they are asked for. */
class Newest {
  private readonly values: number[] = [];
  private sorted: number[] | null = null;
  constructor(private readonly most: number) {}

  add(value: number): void {
    this.values.push(value);
    if (this.values.length > this.most) this.values.shift();
    this.sorted = null;
  }
  clear(): void {
    this.values.length = 0;
    this.sorted = null;
  }
  get sortedValues(): readonly number[] { return (this.sorted ??= [...this.values].sort((a, b) => a - b)); }
  /** `share`: from 0, for the least, to 1. Null without values. */
  at(share: number): number | null { return this.sortedValues[Math.round(share * (this.values.length - 1))] ?? null; }
}

export class Delays {
  private readonly pictures = new Newest(PICTURES);
  private readonly packets = new Newest(PACKETS);

  /** `held`: how much of it the picture was held back. */
  addPicture(delay: number, held: number): void { this.pictures.add(delay - held); }
  /** What the delay must be for this packet to be heard in time. */
  addPacket(need: number): void { this.packets.add(need); }
  clear(): void {
    this.pictures.clear();
    this.packets.clear();
  }

  /** That of pictures that are not held back. */
  get picture(): number | null { return this.pictures.at(0.5); }
  /** With which packets are heard in time. */
  get sound(): number | null {
    const usual = this.packets.at(0.1);
    if (usual === null) return null;
    return this.packets.sortedValues.filter((need) => need <= usual + MOST_LATER).pop()!;
  }
  /** With which both come in time; null as long as there is no sound. */
  get both(): number | null { return this.sound === null ? null : Math.max(this.sound, this.picture ?? -Infinity); }
  /** How long pictures must be held back so that sound comes with them. */
  get hold(): number {
    const longer = (this.sound ?? 0) - (this.picture ?? 0);
    return this.sound === null || this.picture === null || longer > LONGEST_HOLD ? 0 : Math.max(0, longer);
  }
}
