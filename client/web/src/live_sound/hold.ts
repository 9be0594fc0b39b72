// Messages that wait until their time has come.

/** What waits has at most so many bytes; then the oldest is passed on. */
const MOST_BYTES = 64 * 1024 * 1024;

export class Hold<Message extends string | ArrayBuffer> {
  /** How long messages are held from now on, in milliseconds. They stay in order. */
  ms = 0;
  /** How long the last one was held. */
  held = 0;
  private waiting: { message: Message; came: number; due: number }[] = [];
  private bytes = 0;
  private timer = 0;

  constructor(private readonly pass: (message: Message) => void) {}

  put(message: Message): void {
    const came = performance.now(), last = this.waiting[this.waiting.length - 1];
    this.waiting.push({ message, came, due: Math.max(came + this.ms, last?.due ?? 0) });
    this.bytes += Hold.sizeOf(message);
    this.passDue();
  }
  clear(): void {
    clearTimeout(this.timer);
    this.timer = this.bytes = 0;
    this.waiting = [];
  }

  private static sizeOf(message: string | ArrayBuffer): number { return typeof message === "string" ? message.length : message.byteLength; }
  private passDue(): void {
    clearTimeout(this.timer);
    this.timer = 0;
    for (let first = this.waiting[0]; first && (first.due <= performance.now() || this.bytes > MOST_BYTES); first = this.waiting[0]) {
      this.waiting.shift();
      this.bytes -= Hold.sizeOf(first.message);
      this.held = this.ms > 0 ? performance.now() - first.came : 0;
      this.pass(first.message);
    }
    const first = this.waiting[0];
    if (first) this.timer = window.setTimeout(() => this.passDue(), first.due - performance.now());
  }
}
