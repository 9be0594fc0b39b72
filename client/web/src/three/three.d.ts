// What the object uses of three.js, whose types come in a package of their own.
declare module "three" {
  export class Vector4 { x: number; y: number; z: number; w: number; }
  export class Matrix4 {
    readonly elements: number[];
    copy(other: Matrix4): this;
    invert(): this;
    multiply(other: Matrix4): this;
  }
  export class Texture {}
  export class ExternalTexture extends Texture { sourceTexture: WebGLTexture | null; }
  export class BufferAttribute { constructor(array: Float32Array, itemSize: number); }
  export class BufferGeometry {
    setAttribute(name: string, attribute: BufferAttribute): this;
    dispose(): void;
  }
  export class ShaderMaterial {
    constructor(parameters: { vertexShader: string; fragmentShader: string; uniforms: Record<string, { value: unknown }>;
                              toneMapped: boolean });
    readonly uniforms: Record<string, { value: unknown }>;
    dispose(): void;
  }
  export interface Object3DEventMap {}
  export class Mesh<Geometry = BufferGeometry, Material = ShaderMaterial, EventMap = Object3DEventMap> {
    constructor(geometry: Geometry, material: Material);
    readonly geometry: Geometry;
    readonly material: Material;
    readonly matrixWorld: Matrix4;
    frustumCulled: boolean;
    onBeforeRender: (renderer: WebGLRenderer, scene: unknown, camera: Camera) => void;
    raycast(): void;
    dispatchEvent(event: { type: keyof EventMap }): void;
  }
  export class Camera {
    readonly isPerspectiveCamera?: boolean;
    readonly near: number;
    readonly matrixWorld: Matrix4;
    readonly projectionMatrix: Matrix4;
  }
  export interface WebGLRenderTarget {}
  export class WebGLRenderer {
    readonly domElement: HTMLCanvasElement;
    readonly state: {
      readonly buffers: { readonly depth: { getReversed(): boolean; setReversed(reversed: boolean): void } };
      viewport(area: Vector4): void;
    };
    getContext(): WebGL2RenderingContext;
    getCurrentViewport(area: Vector4): Vector4;
    getRenderTarget(): WebGLRenderTarget | null;
    getActiveCubeFace(): number;
    getActiveMipmapLevel(): number;
    setRenderTarget(target: WebGLRenderTarget | null, face: number, level: number): void;
    resetState(): void;
  }
}
