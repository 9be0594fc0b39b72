// What the player uses of WebCodecs, which TypeScript's DOM library does not have.
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
