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
