// <pointreel-player>: the interface of player/element.js. The names that <video> has, too, mean what they mean there.

export type Light = "flat" | "studio" | "environment";
export type Mode = "surfel" | "voxel" | "point" | "strip";

/** The events of HTMLMediaElement, and these. */
export interface PointreelPlayerEventMap extends HTMLElementEventMap {
  /** The first picture is drawn. */
  firstpicture: Event;
  /** The camera was moved. */
  viewchange: Event;
  /** The mode or another setting of drawing was changed. */
  settingschange: Event;
}

export declare class PointreelPlayer extends HTMLElement {
  /** A reel.json, the folder of one, or ws:// addresses of live streams, separated by spaces. */
  src: string;
  /** The address of a picture to show before the first frame. */
  poster: string;
  autoplay: boolean;
  loop: boolean;
  controls: boolean;
  /** From 0 to 1. */
  volume: number;
  /** At first, whether there is an attribute `muted`. */
  muted: boolean;
  mode: Mode;
  /**
   * What colours show: "colors", "normals", "plain", "curvature", "accessibility", "depth", "contours", or the name of a
   * scalar field. Empty for "colors".
   */
  color: string;
  /** The values at the ends of a scalar field's ramp, "0,255"; empty for those of the source. */
  colorRange: string;
  light: Light;
  /** The address of a picture of light, an equirectangular .hdr file; empty for none. With one, `light` is "environment" at first. */
  environment: string;
  /** Of surfaces in the light of a studio or an environment: 0.2, with small and bright highlights, to 1. */
  roughness: number;
  /** From where the whole is seen at first: "front", "back", "left", "right", "top", "bottom", or "YAW,PITCH" in degrees. */
  view: string;
  /** The axis that points up, "x", "-x", "y", "-y", "z" or "-z", in place of the source's. */
  up: string;
  /** Behind what is drawn: "#rrggbb". */
  background: string;
  /** A grid on the floor. */
  floor: boolean;
  /** Where live streams stand: "-0.6,0,0 0.6,0,0", in the units of the sources. */
  places: string;
  /** What a server wants to see before it answers. */
  token: string;
  /** Seconds. */
  currentTime: number;
  /** Seconds; NaN before `loadedmetadata`, Infinity for a live stream. */
  readonly duration: number;
  readonly paused: boolean;
  readonly ended: boolean;
  readonly seeking: boolean;
  /** 0.1 to 4, or negative to play backward. */
  playbackRate: number;
  /** HTMLMediaElement.HAVE_NOTHING to HAVE_ENOUGH_DATA. */
  readonly readyState: number;
  readonly buffered: TimeRanges;
  readonly seekable: TimeRanges;
  /** Why nothing is played; its message is one line. */
  readonly error: Error | null;
  /** The number of the frame that is shown, counted from 0; -1 before the first. */
  readonly frame: number;
  /** How many frames there are; 0 for a live stream. */
  readonly frames: number;
  /** Loads `src` anew. */
  load(): void;
  /** Resolves when frames are shown one after another. */
  play(): Promise<void>;
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
