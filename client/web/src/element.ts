// <pointreel-player>: a player as an element, with attributes, events and methods as <video> has them.
import { Controls } from "./controls/controls";
import { element } from "./controls/dom";
import { MODES, Mode, Vec3 } from "./module";
import { Player, PlayerEvent } from "./player";
import style from "./style.css";

const sheet = new CSSStyleSheet();
sheet.replaceSync(style);

/** "x,y,z x,y,z"; what is no number counts as 0. */
function placesOf(text: string): Vec3[] {
  return text.split(/\s+/).filter((place) => place !== "").map((place) => {
    const [x, y, z] = place.split(",").map((part) => Number(part) || 0);
    return [x ?? 0, y ?? 0, z ?? 0];
  });
}

class Ranges implements TimeRanges {
  constructor(private readonly parts: { from: number; to: number }[]) {}
  get length(): number { return this.parts.length; }
  start(i: number): number { return this.at(i).from / 1e6; }
  end(i: number): number { return this.at(i).to / 1e6; }
  private at(i: number): { from: number; to: number } {
    const part = this.parts[i];
    if (!part) throw new DOMException("no such range", "IndexSizeError");
    return part;
  }
}

/**
 * Attributes: `src` (a reel.json, the folder of one, or ws:// addresses of live streams, separated
 * by spaces), `places` (where live streams stand, as in "-0.6,0,0 0.6,0,0"), `poster`, `autoplay`,
 * `loop`, `controls`, `mode` (surfel, voxel, point), `token`.
 * Events: those of <video>, and `viewchange`, `settingschange`, `firstpicture`.
 */
export class PointreelPlayer extends HTMLElement {
  static readonly observedAttributes = ["src", "loop", "controls", "mode", "poster"];
  readonly player: Player;
  private readonly canvas = element("canvas", { role: "img", tabindex: "0", "aria-label": "Moving point cloud" });
  private readonly spinner = element("div", { class: "spinner" });
  private picture: HTMLImageElement | null = null;
  private controlsShown: Controls | null = null;
  private observer: ResizeObserver | null = null;
  private hasLoaded = false;
  private hasEnded = false;
  private startUs = 0;

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    root.adoptedStyleSheets = [sheet];
    this.spinner.hidden = true;
    root.append(this.canvas, this.spinner);
    this.player = new Player(this.canvas, new URL("./", import.meta.url));
    this.player.onEvent = (name) => this.tell(name);
  }

  connectedCallback(): void {
    this.observer = new ResizeObserver(() => this.fit());
    this.observer.observe(this);
    this.fit();
    if (!this.hasLoaded) this.load();
  }
  disconnectedCallback(): void {
    this.observer?.disconnect();
    this.hasLoaded = false;
    // Moving the element within the page disconnects and connects it again.
    queueMicrotask(() => { if (!this.isConnected) this.player.free(); });
  }
  attributeChangedCallback(name: string): void {
    if (name === "src" && this.isConnected) this.load();
    if (name === "loop" && this.player.isOpen) this.player.setLoop(this.loop);
    if (name === "mode" && (MODES as readonly string[]).includes(this.mode)) this.player.set({ mode: this.mode });
    if (name === "controls") this.showControls();
    if (name === "poster") this.showPoster();
  }

  private fit(): void {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const { width, height } = this.getBoundingClientRect();
    if (width > 0 && height > 0) this.player.resize(Math.round(width * ratio), Math.round(height * ratio));
  }
  private showControls(): void {
    if (this.hasAttribute("controls") && !this.controlsShown) {
      this.controlsShown = new Controls(this, this.canvas, this.player);
      this.shadowRoot!.append(this.controlsShown.root);
      this.controlsShown.update();
    } else if (!this.hasAttribute("controls")) {
      this.controlsShown?.root.remove();
      this.controlsShown = null;
    }
  }
  private showPoster(): void {
    this.picture?.remove();
    this.picture = null;
    if (!this.poster || this.player.pictures > 0) return;
    this.picture = element("img", { class: "poster", src: this.poster, alt: "" });
    this.canvas.after(this.picture);
  }

  /** Loads `src` anew. */
  load(): void {
    this.hasLoaded = true;
    this.hasEnded = false;
    if (!this.src) return this.player.close();
    const sources = this.src.split(/\s+/).filter((s) => s !== "")
      .map((s) => (/^wss?:/.test(s) || /\.json(\?|$)/.test(s) ? s : s.replace(/\/?(\?|$)/, "/reel.json$1")));
    this.spinner.hidden = false;
    this.player.open(sources, this.getAttribute("token"), {
      loop: this.loop, startUs: this.startUs, places: placesOf(this.getAttribute("places") ?? ""),
    }).then(() => {
      if (this.autoplay && this.player.reel) this.player.play();
    });
  }

  private tell(name: PlayerEvent): void {
    if (name === "firstpicture") {
      this.picture?.remove();
      this.spinner.hidden = true;
    }
    if (name === "error") this.spinner.hidden = true;
    if (name === "waiting") this.spinner.hidden = this.player.pictures > 0;
    if (name === "playing") this.spinner.hidden = true;
    if (name === "ended") this.hasEnded = true;
    if (name === "play" || name === "seeking") this.hasEnded = false;
    this.controlsShown?.update();
    this.dispatchEvent(new Event(name));
  }

  // As <video>.

  get src(): string { return this.getAttribute("src") ?? ""; }
  set src(value: string) { this.setAttribute("src", value); }
  get poster(): string { return this.getAttribute("poster") ?? ""; }
  set poster(value: string) { this.setAttribute("poster", value); }
  get autoplay(): boolean { return this.hasAttribute("autoplay"); }
  set autoplay(value: boolean) { this.toggleAttribute("autoplay", value); }
  get loop(): boolean { return this.hasAttribute("loop"); }
  set loop(value: boolean) { this.toggleAttribute("loop", value); }
  get controls(): boolean { return this.hasAttribute("controls"); }
  set controls(value: boolean) { this.toggleAttribute("controls", value); }
  get mode(): Mode { return (this.getAttribute("mode") ?? "surfel") as Mode; }
  set mode(value: Mode) { this.setAttribute("mode", value); }

  get duration(): number { return this.player.reel ? this.player.reel.reel.durationUs / 1e6 : this.player.isLive ? Infinity : NaN; }
  /** Seconds. */
  get currentTime(): number { return this.player.reel ? this.player.reel.clock.read().positionUs / 1e6 : this.startUs / 1e6; }
  set currentTime(seconds: number) {
    if (this.player.reel) this.player.seek(seconds * 1e6);
    else this.startUs = Math.max(0, seconds * 1e6);
  }
  get paused(): boolean { return !this.player.playing; }
  get ended(): boolean { return this.hasEnded; }
  get seeking(): boolean { return this.player.reel?.isSeeking ?? false; }
  get playbackRate(): number { return this.player.reel?.clock.state().speed ?? 1; }
  set playbackRate(rate: number) { this.player.setSpeed(rate); }
  get buffered(): TimeRanges { return new Ranges(this.player.reel?.buffered().filter((part) => part.whole) ?? []); }
  get error(): string | null { return this.player.error; }
  play(): void { this.player.play(); }
  pause(): void { this.player.pause(); }
  /** The number of the frame that is shown, and how many there are. */
  get frame(): number { return this.player.reel?.shown?.frame ?? this.player.live[0]?.shown?.frame ?? -1; }
  get frames(): number { return this.player.reel?.reel.frames ?? 0; }
}

if (!customElements.get("pointreel-player")) customElements.define("pointreel-player", PointreelPlayer);

declare global {
  interface HTMLElementTagNameMap {
    "pointreel-player": PointreelPlayer;
  }
}
