// <pointreel-player>: the interface of web/element.js.

export type Mode = "surfel" | "voxel" | "point";

export interface PointreelPlayerEventMap extends HTMLElementEventMap {
  loadedmetadata: Event;
  /** The first picture is drawn. */
  firstpicture: Event;
  /** The camera was moved. */
  viewchange: Event;
  settingschange: Event;
}

export declare class PointreelPlayer extends HTMLElement {
  /** A reel.json, the folder of one, or ws:// addresses of live streams, separated by spaces. */
  src: string;
  poster: string;
  autoplay: boolean;
  loop: boolean;
  controls: boolean;
  mode: Mode;
  /** Seconds. */
  currentTime: number;
  /** Seconds; NaN before `loadedmetadata`, Infinity for a live stream. */
  readonly duration: number;
  readonly paused: boolean;
  readonly ended: boolean;
  readonly seeking: boolean;
  /** 0.1 to 4, or negative to play backward. */
  playbackRate: number;
  readonly buffered: TimeRanges;
  /** One line, or null. */
  readonly error: string | null;
  /** The number of the frame that is shown, counted from 0; -1 before the first. */
  readonly frame: number;
  readonly frames: number;
  load(): void;
  play(): void;
  pause(): void;
  addEventListener<K extends keyof PointreelPlayerEventMap>(
    type: K, listener: (event: PointreelPlayerEventMap[K]) => void,
    options?: boolean | AddEventListenerOptions): void;
  addEventListener(type: string, listener: EventListenerOrEventListenerObject,
                   options?: boolean | AddEventListenerOptions): void;
}

declare global {
  interface HTMLElementTagNameMap {
    "pointreel-player": PointreelPlayer;
  }
}
