// The interface of player/three.js: reels as objects of three.js scenes.
import type { BufferGeometry, Mesh, Object3DEventMap, ShaderMaterial, WebGLRenderer } from "three";

export type PointreelObjectEvent = "loadedmetadata" | "firstpicture" | "play" | "pause" | "seeking" | "seeked" |
  "timeupdate" | "waiting" | "playing" | "ended" | "error" | "progress" | "viewchange" | "settingschange" |
  "ratechange" | "volumechange";

export type PointreelObjectEventMap = Object3DEventMap & { [name in PointreelObjectEvent]: {} };

/**
 * A reel, or live streams. It stands at the object's origin, on y = 0, with its front to +z. It is as high as it was
 * captured if that is between 0.5 and 3 m, and 1.7 m otherwise. Position, rotation and equal scales of all axes apply
 * to it as to any object.
 */
export declare class PointreelObject extends Mesh<BufferGeometry, ShaderMaterial, PointreelObjectEventMap> {
  /** `base`: the address of the package's folder `player/`, if this module was bundled. */
  constructor(renderer: WebGLRenderer, options?: { base?: string | URL });
  /**
   * `source`, `token` and `places` are those of the element's attributes. Resolves when the duration and the size are
   * known. Rejects with an Error whose message is one line.
   */
  load(source: string, options?: { loop?: boolean; token?: string; places?: string }): Promise<void>;
  play(): void;
  pause(): void;
  /** Stops it for good, and frees what it has made in the renderer's context. */
  dispose(): void;
  readonly paused: boolean;
  /** Seconds; NaN before it is loaded, Infinity for live streams. */
  readonly duration: number;
  /** Seconds. */
  currentTime: number;
  /** 0.1 to 4, or negative to play backward. */
  playbackRate: number;
  /** From 0 to 1. Sound comes from everywhere, not from the object. */
  volume: number;
  muted: boolean;
  mode: "surfel" | "voxel" | "point" | "strip";
  /** Shade by the reel's own light, which comes from over the camera's shoulder. The scene's lights do not count. */
  lighting: boolean;
  /** The number of the frame that is shown, counted from 0; -1 before the first. */
  readonly frame: number;
  /** What is wrong at the moment, in one line, or null. */
  readonly error: string | null;
  /** Width, height and depth in the object's coordinates; null before they are known. */
  readonly size: [number, number, number] | null;
}
