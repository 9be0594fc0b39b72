// The line on which the time is shown and dragged: a slider for keyboards and screen readers, too.
import { Player } from "../player";
import { element } from "./dom";
import { markedA } from "./keys";
import { timeText } from "./time_text";

export class Timeline {
  readonly root = element("div", {
    class: "timeline", part: "timeline", role: "slider", tabindex: "0", "aria-label": "Time", "aria-valuemin": "0",
  });
  private readonly parts = element("div", { class: "parts" });
  private readonly played = element("div", { class: "played" });
  private readonly range = element("div", { class: "range" });
  private readonly knob = element("div", { class: "knob" });
  private readonly hint = element("output", { class: "hint" });
  private drawnParts = 0;
  private frame = -1;

  constructor(private readonly player: Player) {
    const track = element("div", { class: "track" }, this.parts, this.played, this.range, this.knob);
    this.hint.hidden = true;
    this.root.append(track, this.hint);
    let drags = false;
    this.root.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !player.reel) return;
      drags = true;
      this.root.setPointerCapture(event.pointerId);
      player.scrub(this.timeAt(event.clientX));
      this.showHint(event.clientX);
    });
    this.root.addEventListener("pointermove", (event) => {
      if (drags) player.scrub(this.timeAt(event.clientX));
      this.showHint(event.clientX);
    });
    const end = () => {
      if (drags) player.scrub(null);
      drags = false;
      this.hint.hidden = true;
    };
    this.root.addEventListener("pointerup", end);
    this.root.addEventListener("pointercancel", end);
    this.root.addEventListener("pointerleave", () => { if (!drags) this.hint.hidden = true; });
    this.root.addEventListener("wheel", (event) => {
      event.preventDefault();
      player.step(event.deltaY > 0 ? 1 : -1);
    }, { passive: false });
  }

  private timeAt(x: number): number {
    const box = this.root.getBoundingClientRect(), us = this.player.reel?.reel.durationUs ?? 0;
    return Math.min(1, Math.max(0, (x - box.left) / box.width)) * us;
  }
  private showHint(x: number): void {
    const reel = this.player.reel;
    if (!reel) return;
    const us = this.timeAt(x), box = this.root.getBoundingClientRect();
    this.hint.hidden = false;
    this.hint.textContent = `${timeText(us)}   frame ${reel.clock.frameAt(us) + 1}`;
    const half = this.hint.offsetWidth / 2;
    this.hint.style.left = `${Math.min(Math.max(x - box.left, half), box.width - half)}px`;
  }

  update(): void {
    const reel = this.player.reel;
    this.root.hidden = !reel;
    if (!reel) return;
    const duration = Math.max(1, reel.reel.durationUs), at = reel.clock.read();
    const percent = (us: number) => `${(100 * us) / duration}%`;
    this.played.style.width = this.knob.style.left = percent(at.positionUs);
    if (at.frame !== this.frame) {
      this.frame = at.frame;
      this.root.setAttribute("aria-valuemax", String(reel.reel.shownFrames));
      this.root.setAttribute("aria-valuenow", String(reel.reel.shownIndex(at.frame) + 1));
      this.root.setAttribute("aria-valuetext", `${timeText(at.positionUs)}, frame ${reel.reel.shownIndex(at.frame) + 1} of ${reel.reel.shownFrames}`);
    }
    const range = reel.clock.state().range, a = range?.a ?? markedA(this.player);
    this.range.hidden = a === undefined;
    if (a !== undefined) {
      this.range.style.left = percent(a);
      this.range.style.width = range ? percent(range.b - range.a) : "2px";
    }
    if (performance.now() - this.drawnParts < 250) return;
    this.drawnParts = performance.now();
    this.parts.replaceChildren(...reel.buffered().map(({ from, to, whole }) => {
      const part = element("div", { class: whole ? "whole" : "coarse" });
      part.style.left = percent(from);
      part.style.width = percent(to - from);
      return part;
    }));
  }
}
