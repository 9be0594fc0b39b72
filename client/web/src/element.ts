// <pointreel-player>: a player as an element, with attributes, events and methods as <video> has them.
import type { PointreelPlayer as Declared } from "../package/element";
import { directionOf, upOf } from "./camera";
import { coloringOf, rgbOf, roughnessOf } from "./colors";
import { Controls } from "./controls/controls";
import { element } from "./controls/dom";
import { drawLegend } from "./legend";
import { Light, LIGHTS, MODES, Mode } from "./module";
import { DEFAULTS, Player, PlayerEvent, Settings } from "./player";
import { placesOf, sourcesOf } from "./sources";
import style from "./style.css";

const sheet = new CSSStyleSheet();
sheet.replaceSync(style);

/** Attributes that are settings of the player. */
const SETTINGS = ["mode", "color", "color-range", "light", "environment", "roughness", "background", "floor"];

interface Range {
  /** Microseconds. */
  from: number;
  to: number;
}

class Ranges implements TimeRanges {
  constructor(private readonly parts: readonly Range[]) {}
  get length(): number { return this.parts.length; }
  start(i: number): number { return this.at(i).from / 1e6; }
  end(i: number): number { return this.at(i).to / 1e6; }
  private at(i: number): Range {
    const part = this.parts[i];
    if (!part) throw new DOMException("no such range", "IndexSizeError");
    return part;
  }
}

/** As the properties of <video> take what stands for a number, such as the value of a slider, and refuse what does not. */
function finite(value: number, name: string): number {
  const number = Number(value);
  if (!Number.isFinite(number)) throw new TypeError(`${name} must be a finite number, not ${value}`);
  return number;
}

/** A promise that play() has given. */
interface Starting {
  resolve(): void;
  reject(error: DOMException): void;
}

/** The attributes, properties and events are those of package/element.d.ts. */
export class PointreelPlayer extends HTMLElement implements Declared {
  static readonly observedAttributes = ["src", "loop", "controls", "poster", "view", "up", ...SETTINGS];
  readonly player: Player;
  private readonly canvas = element("canvas", { role: "img", tabindex: "0", "aria-label": "Moving point cloud" });
  private readonly spinner = element("div", { class: "spinner" });
  private picture: HTMLImageElement | null = null;
  private legend: HTMLCanvasElement | null = null;
  private legendOf = "";
  private controlsShown: Controls | null = null;
  private observer: ResizeObserver | null = null;
  private hasLoaded = false;
  private hasEnded = false;
  /** What was asked for; frames may have to come first. */
  private isPaused = true;
  private isRunning = false;
  private starting: Starting[] = [];
  private failure: Error | null = null;
  private hasSought = false;
  private startUs = 0;
  private toldTime = NaN;

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
    if (!this.hasLoaded && this.hasAttribute("muted")) this.muted = true;
    this.observer = new ResizeObserver(() => this.fit());
    this.observer.observe(this);
    this.fit();
    if (!this.hasLoaded) this.load();
  }
  disconnectedCallback(): void {
    this.observer?.disconnect();
    this.observer = null;
    // Moving the element within the page disconnects and connects it again.
    queueMicrotask(() => {
      if (this.isConnected) return;
      this.pause();
      this.player.free();
      this.hasLoaded = false;
    });
  }
  attributeChangedCallback(name: string): void {
    // An element that stands in the page before this script is told of its attributes one by one, while it is connected
    // already: connectedCallback loads it, when all are known.
    if (name === "src" && this.observer) this.load();
    if (name === "loop" && this.player.isOpen) this.player.setLoop(this.loop);
    if (SETTINGS.includes(name)) this.player.set(this.settingsOf(name));
    if (name === "view" || name === "up") this.player.setHome({ up: upOf(this.up), direction: directionOf(this.view) });
    if (name === "controls") this.showControls();
    if (name === "poster") this.showPoster();
  }

  /** What an attribute says of drawing. */
  private settingsOf(name: string): Partial<Settings> {
    switch (name) {
      case "mode":
        return { mode: this.mode };
      case "light":
      case "environment":
        return { light: this.light, environment: this.environment };
      case "roughness":
        return { roughness: this.roughness };
      case "background":
        return { background: rgbOf(this.background) ?? DEFAULTS.background };
      case "floor":
        return { floor: this.floor };
      default:
        return coloringOf(this.color, this.colorRange);
    }
  }
  /** Draws as all attributes say. */
  applySettings(): void { this.player.set(Object.assign({}, ...SETTINGS.map((name) => this.settingsOf(name)))); }

  private fit(): void {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const { width, height } = this.getBoundingClientRect();
    if (width > 0 && height > 0) this.player.resize(Math.round(width * ratio), Math.round(height * ratio));
  }
  private showControls(): void {
    if (this.hasAttribute("controls") && !this.controlsShown) {
      this.controlsShown = new Controls(this, this.canvas, this.player);
      this.shadowRoot!.append(this.controlsShown.root);
      this.player.covered = () => this.controlsShown?.covered ?? 0;
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

  private showLegend(): void {
    const legend = this.player.legend, text = JSON.stringify(legend);
    if (text === this.legendOf) return;
    this.legendOf = text;
    this.legend?.remove();
    this.legend = null;
    if (!legend) return;
    const ratio = window.devicePixelRatio || 1, made = drawLegend(legend, ratio);
    made.className = "legend";
    made.style.width = `${made.width / ratio}px`;
    made.style.height = `${made.height / ratio}px`;
    this.canvas.after(made);
    this.legend = made;
  }

  load(): void {
    // A player without a source may have been asked to play already.
    if (this.hasLoaded) {
      this.isPaused = true;
      this.isRunning = false;
      this.stopStarting("AbortError", "another source was loaded");
      this.dispatchEvent(new Event("emptied"));
    }
    this.hasLoaded = this.src !== "";
    this.hasEnded = false;
    this.failure = null;
    if (!this.src) return this.player.close();
    this.dispatchEvent(new Event("loadstart"));
    this.spinner.hidden = false;
    this.player.open(sourcesOf(this.src), this.token || null, {
      loop: this.loop, startUs: this.startUs, places: placesOf(this.places),
    }).then(() => {
      if (!this.player.isOpen) return;
      if (this.player.playing) return this.tell("play");  // a live stream plays from the start
      if (!this.isPaused || this.autoplay) this.player.play();
    });
  }

  private tell(name: PlayerEvent): void {
    if (name === "firstpicture") {
      this.picture?.remove();
      this.spinner.hidden = true;
    }
    if (name === "error") {
      this.spinner.hidden = true;
      this.failure = new Error(this.player.error ?? "unknown");
    }
    if (name === "timeupdate") this.showLegend();
    if (name === "waiting") this.spinner.hidden = this.player.pictures > 0;
    if (name === "playing") this.spinner.hidden = true;
    if (name === "ended") this.hasEnded = true;
    if (name === "play" || name === "seeking") this.hasEnded = false;
    this.controlsShown?.update();
    this.dispatch(name);
    if (name === "error") this.stopStarting("NotSupportedError", this.failure!.message);
    if (name === "pause") this.stopStarting("AbortError", "it was paused");
  }
  /** Tells what has happened by the events that <video> has. */
  private dispatch(name: PlayerEvent): void {
    const tell = (...names: string[]) => { for (const each of names) this.dispatchEvent(new Event(each)); };
    switch (name) {
      case "loadedmetadata":
        return tell("durationchange", name);
      case "firstpicture":
        return tell(name, "loadeddata", "canplay");
      case "play":
      case "pause":
        if (this.isPaused === (name === "pause")) return;
        this.isPaused = name === "pause";
        tell(name);
        return this.noteRunning();
      case "waiting":
      case "playing":
        return;  // noteRunning tells, also where frames that were there already begin to move
      case "seeking":
        this.hasSought = true;
        return tell(name);
      case "seeked":
        // The first picture, and one after play(), end what no one asked for.
        if (this.hasSought) tell(name);
        this.hasSought = false;
        return;
      case "timeupdate":
        this.noteRunning();
        if (this.currentTime === this.toldTime) return;
        this.toldTime = this.currentTime;
        return tell(name);
      default:
        return tell(name);
    }
  }
  private noteRunning(): void {
    const runs = this.player.playing && this.readyState >= HTMLMediaElement.HAVE_FUTURE_DATA;
    if (runs === this.isRunning) return;
    this.isRunning = runs;
    if (runs) {
      this.dispatchEvent(new Event("playing"));
      for (const { resolve } of this.starting.splice(0)) resolve();
    } else if (!this.isPaused) {
      this.dispatchEvent(new Event("waiting"));
    }
  }
  private stopStarting(name: string, why: string): void {
    for (const { reject } of this.starting.splice(0)) reject(new DOMException(why, name));
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
  get volume(): number { return this.player.volume; }
  set volume(volume: number) {
    volume = finite(volume, "volume");
    if (!(volume >= 0 && volume <= 1)) throw new DOMException("volume is from 0 to 1", "IndexSizeError");
    this.player.setVolume(volume, this.muted);
  }
  get muted(): boolean { return this.player.muted; }
  set muted(muted: boolean) { this.player.setVolume(this.volume, muted); }
  get mode(): Mode { return MODES.find((mode) => mode === this.getAttribute("mode")) ?? "surfel"; }
  set mode(value: Mode) { this.setAttribute("mode", value); }
  get color(): string { return this.getAttribute("color") ?? ""; }
  set color(value: string) { this.setAttribute("color", value); }
  get colorRange(): string { return this.getAttribute("color-range") ?? ""; }
  set colorRange(value: string) { this.setAttribute("color-range", value); }
  get light(): Light {
    return LIGHTS.find((light) => light === this.getAttribute("light")) ?? (this.environment ? "environment" : "flat");
  }
  set light(value: Light) { this.setAttribute("light", value); }
  get environment(): string { return this.getAttribute("environment") ?? ""; }
  set environment(value: string) { this.setAttribute("environment", value); }
  get roughness(): number { return roughnessOf(this.getAttribute("roughness")); }
  set roughness(value: number) { this.setAttribute("roughness", String(value)); }

  get view(): string { return this.getAttribute("view") ?? ""; }
  set view(value: string) { this.setAttribute("view", value); }
  get up(): string { return this.getAttribute("up") ?? ""; }
  set up(value: string) { this.setAttribute("up", value); }
  get background(): string { return this.getAttribute("background") ?? ""; }
  set background(value: string) { this.setAttribute("background", value); }
  get floor(): boolean { return this.hasAttribute("floor"); }
  set floor(value: boolean) { this.toggleAttribute("floor", value); }

  get places(): string { return this.getAttribute("places") ?? ""; }
  set places(value: string) { this.setAttribute("places", value); }
  get token(): string { return this.getAttribute("token") ?? ""; }
  set token(value: string) { this.setAttribute("token", value); }

  get duration(): number { return this.player.duration; }
  get currentTime(): number { return this.player.reel ? this.player.reel.clock.read().positionUs / 1e6 : this.startUs / 1e6; }
  set currentTime(seconds: number) {
    const us = Math.max(0, finite(seconds, "currentTime") * 1e6);
    if (this.player.reel) this.player.seek(Math.min(us, this.player.reel.reel.durationUs));
    else this.startUs = us;
  }
  get paused(): boolean { return this.isPaused; }
  get ended(): boolean { return this.hasEnded; }
  get seeking(): boolean { return this.player.reel?.isSeeking ?? false; }
  get playbackRate(): number { return this.player.speed; }
  set playbackRate(rate: number) { this.player.setSpeed(finite(rate, "playbackRate")); }
  get readyState(): number {
    if (!this.player.isOpen) return HTMLMediaElement.HAVE_NOTHING;
    if (this.player.pictures === 0 || this.seeking) return HTMLMediaElement.HAVE_METADATA;
    return this.player.reel?.isWaiting ? HTMLMediaElement.HAVE_CURRENT_DATA : HTMLMediaElement.HAVE_ENOUGH_DATA;
  }
  get buffered(): TimeRanges { return new Ranges(this.player.reel?.buffered().filter((part) => part.whole) ?? []); }
  get seekable(): TimeRanges {
    return new Ranges(this.player.reel ? [{ from: 0, to: this.player.reel.reel.durationUs }] : []);
  }
  get error(): Error | null { return this.failure; }
  play(): Promise<void> {
    if (this.failure) return Promise.reject(new DOMException(this.failure.message, "NotSupportedError"));
    if (!this.player.isOpen) this.dispatch("play");
    else if (!this.player.playing) this.player.play();
    if (this.isRunning) return Promise.resolve();
    return new Promise((resolve, reject) => this.starting.push({ resolve, reject }));
  }
  pause(): void {
    if (this.player.playing) this.player.pause();
    else this.tell("pause");
  }
  get frame(): number { return this.player.frame; }
  get frames(): number { return this.player.reel?.reel.shownFrames ?? 0; }
}

if (!customElements.get("pointreel-player")) customElements.define("pointreel-player", PointreelPlayer);
