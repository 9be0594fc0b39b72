// The interface of the player: the bar, the panels, and what is said for a moment.
import { followPointers } from "../camera_input";
import { Player } from "../player";
import { element } from "./dom";
import { headsetButtons } from "./headset_buttons";
import { Icon, icon } from "./icons";
import { Interface, press, toggleMute, togglePlay } from "./keys";
import { DrawingPanel, helpPanel, StatisticsPanel } from "./panels";
import { timeText } from "./time_text";
import { Timeline } from "./timeline";

const HIDE_MS = 3000;

export class Controls implements Interface {
  readonly root = element("div", { class: "controls" });
  private readonly bar = element("div", { class: "bar", part: "bar", role: "group", "aria-label": "Player" });
  private readonly time = element("span", { class: "time" });
  private readonly said = element("output", { class: "said", "aria-live": "polite" });
  private readonly trouble = element("p", { class: "trouble", role: "alert" });
  private readonly timeline: Timeline;
  private readonly panels: Record<"help" | "drawing" | "statistics", HTMLElement>;
  private readonly drawing: DrawingPanel;
  private readonly statistics: StatisticsPanel;
  private readonly buttons = new Map<string, HTMLButtonElement>();
  private silence = 0;
  private quiet = 0;

  constructor(private readonly host: HTMLElement, private readonly canvas: HTMLCanvasElement, private readonly player: Player) {
    this.timeline = new Timeline(player);
    this.drawing = new DrawingPanel(player, () => this.toggle("drawing"));
    this.statistics = new StatisticsPanel(player, () => this.toggle("statistics"));
    this.panels = { help: helpPanel(() => this.toggle("help")), drawing: this.drawing.root, statistics: this.statistics.root };
    const left = element("div", { class: "buttons" },
      this.button("back", "back", "One frame back", () => player.step(-1)),
      this.button("play", "play", "Play", () => togglePlay(player, this)),
      this.button("forward", "forward", "One frame forward", () => player.step(1)),
      this.button("loop", "loop", "Loop", () => this.toggleLoop()),
      this.button("sound", "sound", "Sound off", () => toggleMute(player, this)));
    const right = element("div", { class: "buttons" },
      ...headsetButtons(player, (text) => this.say(text)),
      this.button("camera", "camera", "Save a picture", () => this.savePicture()),
      this.button("link", "link", "Copy a link to this view", () => this.copyLink()),
      this.button("help", "help", "Keys and gestures", () => this.toggle("help")),
      this.button("drawing", "drawing", "Drawing settings", () => this.toggle("drawing")),
      this.button("statistics", "statistics", "Statistics", () => this.toggle("statistics")),
      this.button("fullscreen", "fullscreen", "Full screen", () => this.fullscreen()));
    this.bar.append(this.timeline.root, element("div", { class: "row" }, left, this.time, right));
    this.trouble.hidden = true;
    this.root.append(...Object.values(this.panels), this.said, this.trouble, this.bar);
    host.addEventListener("keydown", (event) => this.key(event));
    for (const kind of ["pointermove", "pointerdown", "focusin", "keydown"]) host.addEventListener(kind, () => this.wake());
    followPointers(canvas, player, (share) => player.scrub(share === null ? null : share * (player.reel?.reel.durationUs ?? 0)));
    this.wake();
  }

  /** The share of the picture's height that the bar covers. */
  get covered(): number { return this.bar.offsetHeight / Math.max(1, this.canvas.clientHeight); }

  private button(key: string, image: Icon, label: string, act: () => void): HTMLButtonElement {
    const made = element("button", { type: "button", "aria-label": label, title: label });
    made.innerHTML = icon(image);
    made.onclick = act;
    this.buttons.set(key, made);
    return made;
  }

  private key(event: KeyboardEvent): void {
    const from = event.composedPath()[0] as HTMLElement;
    if ((from.tagName === "INPUT" || from.tagName === "SELECT") && event.key !== "Escape") return;
    // A button is pressed by space and enter.
    if (from.tagName === "BUTTON" && (event.key === " " || event.key === "Enter")) return;
    if (press(event, this.player, this)) event.preventDefault();
  }

  say(text: string): void {
    this.said.textContent = text;
    this.said.classList.add("shown");
    clearTimeout(this.silence);
    this.silence = window.setTimeout(() => this.said.classList.remove("shown"), 1600);
  }
  toggle(name: "help" | "drawing" | "statistics"): void {
    const panel = this.panels[name];
    panel.hidden = !panel.hidden;
    this.buttons.get(name)!.setAttribute("aria-expanded", String(!panel.hidden));
    this.update();
  }
  /** The attribute of the element counts, as that of <video> does. */
  toggleLoop(): void { this.host.toggleAttribute("loop"); }
  leave(): boolean {
    for (const name of ["help", "drawing", "statistics"] as const) {
      if (this.panels[name].hidden) continue;
      this.toggle(name);
      return true;
    }
    return false;
  }
  fullscreen(): void {
    if (document.fullscreenElement) document.exitFullscreen().catch(() => undefined);
    else this.host.requestFullscreen?.().catch(() => this.say("full screen is not allowed here"));
  }
  savePicture(): void {
    this.player.still().then(async (blob) => {
      const name = `pointreel-${(this.player.reel?.clock.read().frame ?? 0) + 1}.png`;
      const file = new File([blob], name, { type: "image/png" });
      if (matchMedia("(pointer: coarse)").matches && navigator.canShare?.({ files: [file] })) {
        await navigator.share({ files: [file] });
        return;
      }
      const link = element("a", { href: URL.createObjectURL(blob), download: name });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
      this.say(`saved ${name}`);
    }).catch((error: Error) => { if (error.name !== "AbortError") this.say(error.message); });
  }
  private copyLink(): void {
    this.host.dispatchEvent(new CustomEvent("link"));
    navigator.clipboard?.writeText(location.href).then(() => this.say("link copied"), () => this.say(location.href));
  }

  /** The bar fades away while nothing is moved and frames play. */
  private wake(): void {
    this.root.classList.remove("asleep");
    clearTimeout(this.quiet);
    this.quiet = window.setTimeout(() => {
      const open = Object.values(this.panels).some((panel) => !panel.hidden);
      if (this.player.playing && !open) this.root.classList.add("asleep");
    }, HIDE_MS);
  }

  update(): void {
    const { player } = this, reel = player.reel;
    const set = (key: string, image: Icon, label: string) => {
      const button = this.buttons.get(key)!;
      if (button.title === label) return;
      button.innerHTML = icon(image);
      button.title = label;
      button.setAttribute("aria-label", label);
    };
    set("play", player.playing ? "pause" : "play", player.playing ? "Pause" : "Play");
    for (const key of ["back", "forward", "loop"]) this.buttons.get(key)!.hidden = !reel;
    this.buttons.get("loop")!.setAttribute("aria-pressed", String(player.loop));
    const { sound } = player, problem = sound?.problem;
    this.buttons.get("sound")!.hidden = !sound;
    set("sound", player.muted || problem ? "muted" : "sound", problem ?? (player.muted ? "Sound on" : "Sound off"));
    if (reel) {
      const at = reel.clock.read(), speed = reel.clock.state().speed;
      const extra = (Math.abs(speed - 1) > 1e-3 ? `   ${speed.toFixed(2)}x` : "") + (reel.isWaiting && player.pictures ? "   buffering" : "");
      this.time.textContent = `${timeText(at.positionUs)} / ${timeText(reel.reel.durationUs)}`;
      this.time.append(element("span", { class: "frame" }, `frame ${reel.reel.shownIndex(at.frame) + 1} / ${reel.reel.shownFrames}${extra}`));
    } else {
      this.time.textContent = player.isLive ? (player.playing ? "live" : "live, paused") : "";
    }
    this.timeline.update();
    this.drawing.update();
    this.statistics.update();
    const trouble = player.trouble;
    this.trouble.hidden = !trouble;
    this.trouble.classList.toggle("alone", player.pictures === 0);
    if (trouble && this.trouble.textContent !== trouble) this.trouble.textContent = trouble;
  }
}
