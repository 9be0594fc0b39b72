import { makeFramebuffer, makeTexture, Size } from "./gl";

/** What is drawn into, in the size of the picture. */
export class Targets {
  readonly color: WebGLTexture;
  readonly depth: WebGLTexture;
  readonly sums: WebGLTexture;
  readonly picture: WebGLFramebuffer;
  readonly resolved: WebGLFramebuffer;
  readonly splats: WebGLFramebuffer;
  readonly onlySums: WebGLFramebuffer;

  constructor(private readonly gl: WebGL2RenderingContext, size: Size) {
    this.color = makeTexture(gl, gl.SRGB8_ALPHA8, size);
    this.depth = makeTexture(gl, gl.DEPTH_COMPONENT32F, size);
    this.sums = makeTexture(gl, gl.RGBA16F, size);
    this.picture = makeFramebuffer(gl, this.color, this.depth);
    this.resolved = makeFramebuffer(gl, this.color);
    this.splats = makeFramebuffer(gl, this.sums, this.depth);
    this.onlySums = makeFramebuffer(gl, this.sums);
  }
  free(): void {
    const { gl } = this;
    for (const f of [this.picture, this.resolved, this.splats, this.onlySums]) gl.deleteFramebuffer(f);
    for (const t of [this.color, this.depth, this.sums]) gl.deleteTexture(t);
  }
}
