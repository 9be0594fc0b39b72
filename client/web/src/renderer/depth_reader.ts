// Depths around a pixel, which only a program can read out of a depth texture.
import { bindTexture, LateProgram, makeFramebuffer, makeTexture, Size } from "./gl";

const REACH = 8;
const EDGE = 2 * REACH + 1;

export interface Seen {
  x: number;
  y: number;
  /** Reversed: the near plane's distance over that of the surface. */
  depth: number;
}

export class DepthReader {
  private readonly bits: WebGLTexture;
  private readonly framebuffer: WebGLFramebuffer;

  constructor(private readonly gl: WebGL2RenderingContext, private readonly program: LateProgram) {
    this.bits = makeTexture(gl, gl.RGBA32UI, { width: EDGE, height: EDGE });
    this.framebuffer = makeFramebuffer(gl, this.bits);
  }
  free(): void {
    this.gl.deleteFramebuffer(this.framebuffer);
    this.gl.deleteTexture(this.bits);
  }

  /** The surface at, or nearest to, a place in pixels from the lower left corner; null if none is near. */
  nearest(depths: WebGLTexture, size: Size, x: number, y: number): Seen | null {
    const column = Math.min(Math.floor(x), size.width - 1), row = Math.min(Math.floor(y), size.height - 1);
    const left = Math.max(column - REACH, 0), bottom = Math.max(row - REACH, 0);
    const read = this.read(depths, left, bottom);
    let least = REACH + 0.5, found: Seen | null = null;
    for (let i = 0; i < EDGE * EDGE; ++i) {
      const column_i = left + (i % EDGE), row_i = bottom + Math.floor(i / EDGE), depth = read[4 * i]!;
      const away = Math.hypot(column_i - column, row_i - row);
      if (column_i >= size.width || row_i >= size.height || !(depth > 0) || away >= least) continue;
      least = away;
      found = away === 0 ? { x, y, depth } : { x: column_i + 0.5, y: row_i + 0.5, depth };
    }
    return found;
  }

  private read(depths: WebGLTexture, left: number, bottom: number): Float32Array {
    const { gl } = this, program = this.program.get();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.viewport(0, 0, EDGE, EDGE);
    for (const off of [gl.BLEND, gl.DEPTH_TEST, gl.SCISSOR_TEST]) gl.disable(off);
    bindTexture(gl, 0, depths);
    program.ivec4("first", left, bottom, 0, 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const bits = new Uint32Array(4 * EDGE * EDGE);
    gl.readPixels(0, 0, EDGE, EDGE, gl.RGBA_INTEGER, gl.UNSIGNED_INT, bits);
    return new Float32Array(bits.buffer);
  }
}
