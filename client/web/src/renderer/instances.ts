import { Packed, ROW_INSTANCES } from "../module";
import { bindTexture, makeTexture } from "./gl";

/** Instances of a frame in a texture, as fetch.glsl reads them. */
export class InstanceTexture {
  private texture: WebGLTexture | null = null;
  private rows = 0;
  count = 0;

  constructor(private readonly gl: WebGL2RenderingContext) {}

  upload(packed: Packed): void {
    const { gl } = this, words = new Uint32Array(packed.instances);
    const rows = words.length / (8 * ROW_INSTANCES), width = 2 * ROW_INSTANCES;
    if (!this.texture || rows > this.rows) {
      this.free();
      this.rows = rows + (rows >> 2);
      this.texture = makeTexture(gl, gl.RGBA32UI, { width, height: this.rows });
    }
    bindTexture(gl, 0, this.texture);
    // Others who share the context may have changed these.
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, rows, gl.RGBA_INTEGER, gl.UNSIGNED_INT, words);
    this.count = packed.count;
  }
  bind(): void { if (this.texture) bindTexture(this.gl, 0, this.texture); }
  free(): void {
    this.gl.deleteTexture(this.texture);
    this.texture = null;
    this.rows = this.count = 0;
  }
}

/** The indices of a frame's triangle strips. */
export class IndexBuffer {
  private array: WebGLVertexArrayObject | null = null;
  private buffer: WebGLBuffer | null = null;

  constructor(private readonly gl: WebGL2RenderingContext) {}

  upload({ indices }: Packed): void {
    const { gl } = this;
    if (indices.length === 0) return;
    this.array ??= gl.createVertexArray();
    this.buffer ??= gl.createBuffer();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.DYNAMIC_DRAW);
    gl.bindVertexArray(null);
  }
  /** WebGL2 always ends a strip at the highest index. */
  draw(first: number, count: number): void {
    if (count === 0) return;
    this.gl.bindVertexArray(this.array);
    this.gl.drawElements(this.gl.TRIANGLE_STRIP, count, this.gl.UNSIGNED_INT, 4 * first);
  }
  free(): void {
    this.gl.deleteVertexArray(this.array);
    this.gl.deleteBuffer(this.buffer);
    this.array = this.buffer = null;
  }
}
