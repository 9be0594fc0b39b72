// What the player uses of WebCodecs, which TypeScript's DOM library does not have.
interface VideoFrameLike {
  readonly format: string | null;
  readonly timestamp: number;
  readonly codedWidth: number;
  readonly codedHeight: number;
  copyTo(destination: ArrayBufferView, options: {
    rect: { x: number; y: number; width: number; height: number };
    layout: { offset: number; stride: number }[];
  }): Promise<unknown>;
  close(): void;
}
interface VideoConfig {
  codec: string;
  codedWidth: number;
  codedHeight: number;
  hardwareAcceleration: "prefer-software";
  optimizeForLatency: boolean;
}
declare class EncodedVideoChunk {
  constructor(init: { type: "key" | "delta"; timestamp: number; data: Uint8Array });
}
declare class VideoDecoder {
  static isConfigSupported(config: VideoConfig): Promise<{ supported: boolean }>;
  constructor(init: { output(frame: VideoFrameLike): void; error(error: DOMException): void });
  readonly state: "unconfigured" | "configured" | "closed";
  configure(config: VideoConfig): void;
  decode(chunk: EncodedVideoChunk): void;
  /** Resolves once all pictures were given. The next chunk must be a key. */
  flush(): Promise<void>;
  close(): void;
}
interface AudioData {
  readonly numberOfFrames: number;
  readonly numberOfChannels: number;
  copyTo(destination: Float32Array, options: { planeIndex: number; format: "f32-planar" }): void;
  close(): void;
}
declare class EncodedAudioChunk {
  constructor(init: { type: "key"; timestamp: number; duration: number; data: Uint8Array });
}
declare class AudioDecoder {
  constructor(init: { output(data: AudioData): void; error(error: DOMException): void });
  readonly decodeQueueSize: number;
  readonly state: "unconfigured" | "configured" | "closed";
  configure(config: { codec: "opus"; sampleRate: number; numberOfChannels: number }): void;
  decode(chunk: EncodedAudioChunk): void;
  close(): void;
}
