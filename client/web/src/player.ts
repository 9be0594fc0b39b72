// A canvas that plays a reel or live streams. Without controls: element.ts has those.
import { Camera } from "./camera";
import { isShadedLate, ScalarChoice, ScalarRange } from "./colors";
import { Content, ContentOptions } from "./content";
import { Environment } from "./environment";
import { Headset } from "./headset";
import { drawLegend, Legend, readLegend } from "./legend";
import type { LivePlayback } from "./live";
import { Box, ColorSource, Light, Mode, Vec3 } from "./module";
import type { MadeFrame, ReelPlayback } from "./playback";
import { Coarsening, FINEST, Pace } from "./pace";
import { contextOf, DrawOptions, Renderer, ScenePart } from "./renderer/renderer";
import type { Soundtrack } from "./sound";
import { Look } from "./view";
import { WholeView } from "./whole_view";

export interface Settings {
  mode: Mode;
  color: ColorSource;
  /** In place of colours; counts with the color "colors". */
  scalar: ScalarChoice | null;
  light: Light;
  /** From LEAST_ROUGHNESS to 1; for other than flat light. */
  roughness: number;
  /** The address of a picture of light (.hdr), or nothing. Until it has come, light is flat. */
  environment: string;
  /** With flat light: one over the viewer's shoulder. */
  lighting: boolean;
  fillHoles: boolean;
  smoothOutlines: boolean;
  floor: boolean;
  /** Pixels; the least with adaptive points, which are as large as the distance between neighbours asks for. */
  pointSize: number;
  adaptivePoints: boolean;
  background: Vec3;
}
export const DEFAULTS: Readonly<Settings> = {
  mode: "surfel", color: "colors", scalar: null, light: "flat", roughness: 0.5, environment: "", lighting: true,
  fillHoles: true, smoothOutlines: true, floor: false,
  pointSize: 2, adaptivePoints: true, background: [0x1c / 255, 0x1f / 255, 0x24 / 255],
};

/** A camera that was moved counts as moving for so long, in milliseconds. */
const MOVES = 150;
const LARGEST_POINT = 64;  // pixels, with adaptive points
const LEGEND_MARGIN = 12, LEGEND_REFERENCE = 540;  // pixels; the height of a saved picture that does not enlarge its legend

export type PlayerEvent =
  "loadedmetadata" | "firstpicture" | "play" | "pause" | "seeking" | "seeked" | "timeupdate" | "waiting" |
  "playing" | "ended" | "error" | "progress" | "viewchange" | "settingschange" | "ratechange" | "volumechange";

/** From where the whole scene is seen at first. */
export interface Home {
  /** PrCamera's; null: as the source says. */
  up: number | null;
  /** Yaw and pitch; null: the front, slightly from above. */
  direction: readonly [number, number] | null;
}

/** Shows pictures in place of the canvas, and calls drawFrame for each. */
export interface Display {
  /** Null before anything is known. */
  view(): WholeView | null;
  /** `reduction`: how many times fewer pixels there are along each side. Returns how many instances were drawn. */
  draw(renderer: Renderer, parts: readonly ScenePart[], options: DrawOptions, reduction: number): number;
  leave(): void;
}

/** A canvas's context that others draw with, too. */
export interface SharedContext {
  readonly gl: WebGL2RenderingContext;
  /** Does something with the context in its initial state, and then restores that of the others. */
  use<Result>(act: () => Result): Result;
}

export class Player {
  readonly settings: Settings = { ...DEFAULTS, background: [...DEFAULTS.background] };
  camera: Camera | null = null;
  /** One line for people, or null. */
  error: string | null = null;
  /** Milliseconds of the last picture. */
  drawMs = 0;
  drawn = 0;
  pictures = 0;
  onEvent: (name: PlayerEvent) => void = () => undefined;
  private renderer: Renderer | null = null;
  private content: Content | null = null;
  private environment: Environment | null = null;
  /** Null for the canvas. */
  display: Display | null = null;
  private seen: WholeView | null = null;
  private opening: AbortController | null = null;
  private waitsFor: string | null = null;
  private scheduled = 0;
  private lookNumber = 1;
  private moved = 0;
  private hasMoved = false;
  private hasBounds = false;
  private dirty = true;
  private wasWaiting = false;
  private wasSeeking = false;
  private readonly pace = new Pace();
  private coarsening: Coarsening = FINEST;
  private wantsLoop = false;
  private loudness = 1;
  private isMuted = false;
  private homeAspect = 0;
  private home: Home = { up: null, direction: null };
  /** The share of the picture's height that controls cover, at its bottom. */
  covered = (): number => 0;
  /** To be applied once there is a camera. */
  firstView: ((camera: Camera) => void) | null = null;

  /** The canvas's context, while there is no renderer for it. */
  private givenBack: WEBGL_lose_context | null = null;

  /** With a shared context, a display must be set that calls drawFrame. */
  constructor(readonly canvas: HTMLCanvasElement, private readonly base: URL, private readonly shared: SharedContext | null = null) {
    // Only a context whose loss is handled can be restored.
    canvas.addEventListener("webglcontextlost", (event) => { if (this.givenBack) event.preventDefault(); });
  }

  get reel(): ReelPlayback | null { return this.content?.reel ?? null; }
  get live(): readonly LivePlayback[] { return this.content?.live ?? []; }
  get isOpen(): boolean { return this.content !== null; }
  get isLive(): boolean { return this.live.length > 0; }
  get driver(): string { return this.renderer?.driver ?? ""; }
  get traffic(): { bytes: number; requests: number } { return this.content?.traffic ?? { bytes: 0, requests: 0 }; }
  get memory(): number { return this.content?.memory ?? 0; }
  /** What is wrong at the moment, in one line, or null. */
  get trouble(): string | null {
    const { color, light } = this.settings, lacksLight = this.renderer?.canShade === false && isShadedLate(color, light);
    return this.error ?? (this.content ? this.content.trouble : this.waitsFor) ?? this.missingField() ?? this.environment?.trouble ??
      (lacksLight ? "this graphics driver cannot draw light and false colours" : null);
  }

  /** The scalar fields of what is open, as far as they are known. */
  get scalars(): readonly ScalarRange[] { return this.content?.scalars ?? []; }
  /** The scalar field that is asked for. */
  private get scalar(): ScalarChoice | null { return this.settings.color === "colors" ? this.settings.scalar : null; }
  private get light(): Light {
    const { light } = this.settings;
    return light === "environment" && !this.environment?.handle ? "flat" : light;
  }
  private missingField(): string | null {
    const { scalar, scalars } = this;
    if (!scalar || !this.reel || scalars.some(({ name }) => name === scalar.field)) return null;
    return `there is no scalar field "${scalar.field}"; ` +
      (scalars.length > 0 ? `there are ${scalars.map(({ name }) => name).join(", ")}` : "there are none");
  }
  /** What the colours of the picture mean, if they stand for values. */
  get legend(): Legend | null {
    const shown = this.painted.find(({ facts }) => facts.legend !== "");
    return shown ? readLegend(shown.facts.legend) : null;
  }

  /** As Content.open. */
  async open(sources: readonly string[], token: string | null, options: ContentOptions): Promise<void> {
    this.close();
    const opening = new AbortController();
    this.opening = opening;
    this.wantsLoop = options.loop;
    let content: Promise<Content> | null = null;
    try {
      content = Content.open(this.base, sources, token, { ...options, muted: this.isMuted }, () => this.schedule(),
                             (why) => this.tellWaiting(why), opening.signal);
      content.catch(() => undefined);
      // While it is on its way, the driver makes a context and compiles.
      await this.makeRenderer(opening.signal);
      const opened = await content;
      opening.signal.throwIfAborted();
      this.content = opened;
      opened.setVolume(this.loudness, this.isMuted);
      this.camera = new Camera(opened.module, this.home.up ?? opened.up);
      this.environment ??= new Environment(opened.module, () => this.set({}));
      this.environment.follow(this.settings.environment);
      if (this.reel) {
        this.lookHome();
        if (this.firstView) this.applyFirstView();
      }
      this.onEvent("loadedmetadata");
      this.schedule();
    } catch (error) {
      content?.then((unused) => unused.free(), () => undefined);
      if (opening.signal.aborted) return;
      this.content = null;
      opening.abort();
      this.fail((error as Error).message);
    }
  }
  private async makeRenderer(signal: AbortSignal): Promise<void> {
    if (this.givenBack) await this.takeContext(this.givenBack);
    signal.throwIfAborted();
    const { shared } = this;
    this.renderer ??= shared ? shared.use(() => new Renderer(shared.gl)) : new Renderer(contextOf(this.canvas));
    this.renderer.startCompiling(this.settings);
  }
  private async takeContext(context: WEBGL_lose_context): Promise<void> {
    const restored = new Promise((resolve) => this.canvas.addEventListener("webglcontextrestored", resolve, { once: true }));
    context.restoreContext();
    await restored;
    this.givenBack = null;
  }
  close(): void {
    this.opening?.abort();
    this.content?.free();
    this.content = null;
    this.error = this.waitsFor = null;
    this.hasMoved = this.hasBounds = false;
    this.pictures = 0;
  }
  free(): void {
    this.display?.leave();
    this.close();
    cancelAnimationFrame(this.scheduled);
    this.scheduled = 0;
    this.environment?.free();
    this.environment = null;
    const { renderer, shared } = this;
    this.renderer = null;
    if (!renderer) return;
    if (shared) return shared.use(() => renderer.free());
    // The canvas never gets another context, but browsers allow only a few at a time.
    this.givenBack = renderer.gl.getExtension("WEBGL_lose_context");
    this.givenBack?.loseContext();
  }
  /** Before there is a picture, nothing else tells of the link. */
  private tellWaiting(why: string | null): void {
    this.waitsFor = why;
    if (this.pictures === 0) this.onEvent("waiting");
  }
  private fail(message: string): void {
    this.error = message;
    this.onEvent("error");
  }

  // Time.

  get playing(): boolean {
    return this.reel ? this.reel.clock.state().playing : this.live.some((live) => live.playing);
  }
  get loop(): boolean { return this.reel?.clock.state().loop ?? this.wantsLoop; }
  play(): void {
    this.reel?.play();
    for (const live of this.live) live.playing = true;
    this.onEvent("play");
    this.schedule();
  }
  pause(): void {
    this.reel?.pause();
    for (const live of this.live) live.playing = false;
    this.onEvent("pause");
    this.schedule();
  }
  private withReel(act: (reel: ReelPlayback) => void, event?: PlayerEvent): void {
    if (!this.reel) return;
    act(this.reel);
    if (event) this.onEvent(event);
    this.schedule();
  }
  seek(us: number): void { this.withReel((reel) => reel.seek(us), "seeking"); }
  seekBy(us: number): void { this.withReel((reel) => reel.seekBy(us), "seeking"); }
  step(frames: number): void {
    const played = this.playing;
    this.withReel((reel) => reel.step(frames), "seeking");
    if (played) this.onEvent("pause");
  }
  /** Seconds; NaN before a reel is open, Infinity for live streams. */
  get duration(): number { return this.reel ? this.reel.reel.durationUs / 1e6 : this.isLive ? Infinity : NaN; }
  get speed(): number { return this.reel?.clock.state().speed ?? 1; }
  /** The number of the frame that is shown, from 0; -1 before the first. */
  get frame(): number {
    const shown = this.reel?.shown;
    return shown ? this.reel!.reel.shownIndex(shown.frame) : this.live[0]?.shown?.frame ?? -1;
  }
  setSpeed(speed: number): void { this.withReel((reel) => reel.clock.setSpeed(speed), "ratechange"); }
  setLoop(loop: boolean): void {
    this.wantsLoop = loop;
    this.withReel((reel) => reel.clock.setLoop(loop));
  }
  setRange(range: { a: number; b: number } | null): void { this.withReel((reel) => reel.clock.setRange(range)); }
  /** Dragging the time: coarse pictures first. */
  scrub(us: number | null): void {
    this.withReel((reel) => {
      reel.scrubbing = us !== null;
      if (us !== null) reel.seek(us);
    }, us !== null ? "seeking" : undefined);
  }

  // Sound.

  /** Null if nothing that is open has sound. */
  get sound(): Soundtrack | null { return this.content?.soundtrack ?? null; }
  get volume(): number { return this.loudness; }
  get muted(): boolean { return this.isMuted; }
  /** `volume`: from 0 to 1, as of <video>. */
  setVolume(volume: number, muted: boolean): void {
    this.loudness = Math.max(0, Math.min(1, volume));
    this.isMuted = muted;
    this.content?.setVolume(this.loudness, muted);
    this.onEvent("volumechange");
  }

  // What is seen.

  set(settings: Partial<Settings>): void {
    Object.assign(this.settings, settings);
    this.environment?.follow(this.settings.environment);
    this.lookNumber += 1;
    this.dirty = true;
    this.onEvent("settingschange");
    this.schedule();
  }
  move(act: (camera: Camera) => void): void {
    if (!this.camera) return;
    act(this.camera);
    this.hasMoved = true;
    this.moved = performance.now();
    this.lookNumber += 1;
    this.dirty = true;
    this.onEvent("viewchange");
    this.schedule();
  }
  setHome(home: Home): void {
    this.home = home;
    this.lookHome();
  }
  lookHome(): void {
    const box = this.content?.viewBounds() ?? null;
    if (!this.camera || !box) return;
    this.camera.state[8] = this.home.up ?? this.content?.up ?? 2;
    this.homeAspect = this.aspect;
    this.camera.frameBounds(box, this.aspect);
    if (this.home.direction) this.camera.lookAlong(this.home.direction);
    this.camera.fit(box, this.aspect, this.covered());
    this.hasMoved = false;
    this.hasBounds = true;
    this.lookNumber += 1;
    this.dirty = true;
    this.onEvent("viewchange");
    this.schedule();
  }
  bounds(): Box | null { return this.content?.bounds() ?? null; }
  pointAt(x: number, y: number): Vec3 | null { return this.renderer?.pointAt(x, y) ?? null; }
  get aspect(): number { return this.canvas.width / Math.max(1, this.canvas.height); }
  private applyFirstView(): void {
    const view = this.firstView;
    this.firstView = null;
    if (view) this.move(view);
  }

  resize(width: number, height: number): void {
    if (this.canvas.width === width && this.canvas.height === height) return;
    this.canvas.width = Math.max(1, width);
    this.canvas.height = Math.max(1, height);
    if (!this.hasMoved && this.aspect !== this.homeAspect) this.lookHome();
    this.lookNumber += 1;
    this.dirty = true;
    // At once: the canvas was cleared.
    if (!this.display) this.tick();
  }

  /** The picture as it is shown, in full quality, with its legend. */
  async still(): Promise<Blob> {
    this.coarsening = FINEST;
    this.paint();
    const { legend, canvas } = this;
    let picture = canvas;
    if (legend) {
      const key = drawLegend(legend, Math.max(1, Math.floor(canvas.height / LEGEND_REFERENCE)));
      picture = document.createElement("canvas");
      picture.width = canvas.width;
      picture.height = canvas.height;
      const pen = picture.getContext("2d")!;
      pen.drawImage(canvas, 0, 0);
      pen.drawImage(key, LEGEND_MARGIN, canvas.height - key.height - LEGEND_MARGIN);
    }
    return new Promise((resolve, reject) => picture.toBlob(
      (blob) => (blob ? resolve(blob) : reject(new Error("the picture cannot be saved"))), "image/png"));
  }

  /** Shows the scene in a headset, until it is taken off. */
  async enter(mode: XRSessionMode): Promise<void> {
    if (!this.renderer || !this.camera) throw new Error("nothing is open that a headset could show");
    this.display = await Headset.enter(mode, this, this.renderer, this.camera.module, () => {
      this.display = this.seen = null;
      this.lookNumber += 1;
      this.dirty = true;
      this.onEvent("viewchange");
      this.schedule();
    });
    this.onEvent("viewchange");
  }
  /** For the display's frames, each of which needs a picture. */
  drawFrame(): void {
    this.dirty = true;
    this.tick();
  }

  schedule(): void {
    if (this.display) return;
    if (this.scheduled === 0) this.scheduled = requestAnimationFrame(() => {
      this.scheduled = 0;
      this.tick();
    });
  }

  private look(): Look {
    const seen = this.display?.view() ?? null, now = performance.now();
    if (seen !== this.seen) {
      this.lookNumber += 1;
      this.moved = now;
    }
    this.seen = seen;
    const moves = now - this.moved <= MOVES || (this.reel !== null && this.reel.reel.shownFrames > 1 && this.playing);
    const resting = !this.display && !moves && !this.reel?.scrubbing && !this.reel?.isSeeking;
    if (resting !== this.rested) {
      this.rested = resting;
      this.lookNumber += 1;
    }
    const coarsening = this.pace.coarsening(moves), { pixelSize } = coarsening;
    if (pixelSize !== this.coarsening.pixelSize) this.lookNumber += 1;
    if (coarsening.reduction < this.coarsening.reduction) this.dirty = true;
    this.coarsening = coarsening;
    const { mode, color, fillHoles } = this.settings, { light } = this;
    return { camera: seen?.camera ?? this.camera!, width: seen?.size ?? this.canvas.width,
             height: seen?.size ?? this.canvas.height, mode, color, light, scalar: this.scalar, fillHoles,
             refine: resting && mode === "surfel", pixelSize, number: this.lookNumber };
  }
  private rested = false;

  private tick(): void {
    if (!this.camera || !this.renderer) return;
    if (this.renderer.isLost) {
      if (!this.error) this.fail("the graphics driver has lost this page's pictures; load the page again");
      return;
    }
    try {
      this.update();
    } catch (error) {
      this.fail((error as Error).message);
    }
  }

  private update(): void {
    const look = this.look(), now = performance.now();
    if (this.isLive && !this.hasBounds && this.bounds()) {
      this.lookHome();
      this.applyFirstView();
    }
    if (this.reel?.update(look)) this.dirty = true;
    if (this.reel) this.content?.sound?.follow(this.reel.clock);
    for (const live of this.live) live.update(look);
    // Where the points are is known only from a frame.
    if (this.content?.noteShown() && !this.hasMoved) this.lookHome();
    const parts = this.content?.shown() ?? [];
    if (parts.some((part, i) => part !== this.painted[i]) || parts.length !== this.painted.length) this.dirty = true;
    const resting = this.rested;
    if (resting || this.reel?.isWaiting) this.pace.pause();
    else this.pace.tick(now);
    if (this.dirty) this.paint();
    this.tell();
    const playing = this.playing && document.visibilityState === "visible";
    if ((this.reel && playing) || !resting || this.reel?.isWaiting) this.schedule();
  }
  private painted: MadeFrame[] = [];

  private paint(): void {
    const { renderer, camera, canvas } = this;
    if (!renderer || !camera) return;
    const start = performance.now(), parts = this.content?.shown() ?? [], bounds = this.bounds();
    // After a change of the mode, frames are drawn in the old one until there are others.
    const mode = parts[0]?.mode ?? this.settings.mode;
    const { reduction } = this.coarsening;
    const side = renderer.largestSide, r = Math.max(reduction, Math.ceil(Math.max(canvas.width, canvas.height) / side));
    const options: DrawOptions = {
      ...this.settings, light: this.light, environment: this.environment?.handle ?? 0, mode, pointSize: this.settings.pointSize * (window.devicePixelRatio || 1) / r,
      largestPoint: this.settings.adaptivePoints ? LARGEST_POINT / r : 0,
      floor: this.settings.floor && bounds ? { box: bounds, camera } : null,
    };
    const size = { width: Math.ceil(canvas.width / r), height: Math.ceil(canvas.height / r) };
    const drawable = parts.filter((part) => part.mode === mode);
    if (this.display) {
      this.drawn = this.display.draw(renderer, drawable, options, reduction);
    } else {
      this.drawn = renderer.draw(drawable, camera, size, options);
      renderer.present();
    }
    this.painted = parts;
    this.noteDrawn();
    this.dirty = false;
    this.drawMs = performance.now() - start;
    if (parts.length > 0 && this.pictures++ === 0) this.onEvent("firstpicture");
  }

  /** What was drawn is seen about when the next picture could be. Headsets may have stopped what tells that. */
  private noteDrawn(): void {
    const notes = this.live.map((live) => live.noteDrawn()), note = () => { for (const each of notes) each?.(); };
    if (this.display) note();
    else requestAnimationFrame(note);
  }

  private tell(): void {
    this.onEvent("timeupdate");
    const waiting = this.reel?.isWaiting ?? false, seeking = this.reel?.isSeeking ?? false;
    if (waiting !== this.wasWaiting) this.onEvent(waiting ? "waiting" : "playing");
    if (this.wasSeeking && !seeking) this.onEvent("seeked");
    this.wasWaiting = waiting;
    this.wasSeeking = seeking;
    if (this.reel && this.playing && this.reel.clock.read().ended) {
      this.reel.pause();
      this.onEvent("pause");
      this.onEvent("ended");
    }
  }

}
