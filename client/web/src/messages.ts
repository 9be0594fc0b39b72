// What the page and its workers say to each other.
import { FrameFacts, Packed } from "./module";

export interface Open {
  type: "open";
  compiled: WebAssembly.Module;
  tables: Uint8Array;
}
/** A reel's own context tables, for the jobs that name them. */
export interface LoadTables {
  type: "tables";
  tables: number;
  bytes: Uint8Array;
  checksum: string;
}
/** A frame's group of video, which has a number of its own, and its place in it. */
export interface VideoPlace {
  group: number;
  index: number;
}
export interface Prepare {
  type: "prepare";
  job: number;
  key: number;
  bytes: Uint8Array;
  /** Of geometry, colours and normals of each layer; of video, of each frame of the group. */
  sizes: Uint32Array;
  video: VideoPlace | null;
  /** 0: none. */
  tables: number;
  /** PrPrepare. */
  options: Float64Array;
  /** The name of the scalar field to show, or nothing. */
  field: string;
  /** PrScalar. */
  scalar: Float64Array;
  /** PrView. */
  view: Float64Array;
}
export interface Pack {
  type: "pack";
  job: number;
  key: number;
  view: Float64Array;
}
export interface Drop {
  type: "drop";
  keys: number[];
}
export type ToWorker = Open | LoadTables | Prepare | Pack | Drop;

export interface Times {
  prepareMs: number;
  packMs: number;
}
export interface Done {
  type: "done";
  job: number;
  facts: FrameFacts;
  packed: Packed;
  times: Times;
  /** Bytes allocated in the worker's module. */
  memory: number;
}
export interface Failed {
  type: "failed";
  job: number;
  message: string;
  /** The module trapped: its worker must be replaced. */
  trapped: boolean;
  /** The browser does not decode the video. */
  noVideo: boolean;
}
export interface Opened {
  type: "opened";
}
export type FromWorker = Opened | Done | Failed;
