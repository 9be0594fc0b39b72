// Fills the holes of a splatted surface, as client/render/opengl/reconstruction.h explains.
import { bindTexture, makeFramebuffer, makeTexture, Size } from "./gl";
import { around, EMPTY, Rect } from "./region";
import { Programs } from "./shaders";

const FINEST = 4;
const FARTHEST = 2;
const GAP = 6.5;
const REACH = 1.2;
const BACK_TOLERANCE = 1;

interface Level {
  texture: WebGLTexture;
  framebuffer: WebGLFramebuffer;
  size: Size;
}

export interface Filling {
  colors: WebGLTexture;
  crowd: WebGLTexture;
  crowdEdge: number;
}

function coarserPart(part: Rect, times: number, size: Size): Rect {
  const up = (value: number) => Math.floor((value + times - 1) / times) + 1;
  return { x0: Math.max(Math.floor(part.x0 / times) - 1, 0), y0: Math.max(Math.floor(part.y0 / times) - 1, 0),
           x1: Math.min(up(part.x1), size.width), y1: Math.min(up(part.y1), size.height) };
}

export class Reconstruction {
  private pulled: Level[] = [];
  private pushed: Level[] = [];
  private pulledRegion: Rect = EMPTY;

  constructor(private readonly gl: WebGL2RenderingContext, private readonly programs: Programs) {}

  free(): void {
    for (const level of [...this.pulled, ...this.pushed]) {
      this.gl.deleteFramebuffer(level.framebuffer);
      this.gl.deleteTexture(level.texture);
    }
    this.pulled = [];
    this.pushed = [];
  }

  resize(size: Size): void {
    const { gl } = this;
    this.free();
    const make = (texels: Size): Level => {
      const texture = makeTexture(gl, gl.RGBA16F, texels, gl.LINEAR);
      const framebuffer = makeFramebuffer(gl, texture);
      gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
      return { texture, framebuffer, size: texels };
    };
    const half = (n: number) => Math.floor((n + 1) / 2);
    let texels = { width: Math.ceil(size.width / FINEST), height: Math.ceil(size.height / FINEST) };
    for (let edge = FINEST;; edge *= 2) {
      this.pulled.push(make(texels));
      if (edge * FARTHEST >= size.height || (texels.width === 1 && texels.height === 1)) break;
      this.pushed.push(make(texels));
      texels = { width: half(texels.width), height: half(texels.height) };
    }
    this.pulledRegion = EMPTY;
  }

  /** Into the depth buffer of the bound framebuffer. The instances are bound. */
  drawBacks(count: number, oneIn: number): void {
    const program = this.programs.back.get();
    program.float("reach", REACH * Math.sqrt(oneIn));
    program.float("tolerance", BACK_TOLERANCE);
    program.uint("one_in", oneIn);
    this.gl.drawArrays(this.gl.POINTS, 0, count);
  }

  /** In the bound framebuffer, which has only the sums. */
  clearSeeThrough(depth: WebGLTexture, radius: number, nearest: number): void {
    const program = this.programs.seeThrough.get();
    bindTexture(this.gl, 0, depth);
    program.float("radius", radius);
    program.float("nearest", nearest);
    this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
  }

  fill(sums: WebGLTexture, region: Rect, radius: number, size: Size): Filling {
    const { gl } = this;
    let toPull = around(this.pulledRegion, region), part = region;
    this.pulledRegion = region;
    const toPush = this.pushed.map((level, i) => (part = coarserPart(part, i === 0 ? FINEST : 2, level.size)));
    gl.enable(gl.SCISSOR_TEST);
    let finer = sums;
    this.pulled.forEach((level, i) => {
      (i === 0 ? this.programs.pullSums : this.programs.pull).get();
      bindTexture(gl, 0, finer);
      toPull = coarserPart(toPull, i === 0 ? FINEST : 2, level.size);
      this.draw(level, toPull);
      finer = level.texture;
    });
    this.programs.push.get();
    let filled = finer;
    for (let i = this.pushed.length; i-- > 0;) {
      bindTexture(gl, 0, this.pulled[i]!.texture);
      bindTexture(gl, 1, filled);
      this.draw(this.pushed[i]!, toPush[i]!);
      filled = this.pushed[i]!.texture;
    }
    gl.disable(gl.SCISSOR_TEST);
    gl.viewport(0, 0, size.width, size.height);
    let crowd = 0, edge = FINEST;
    while (crowd + 1 < this.pulled.length && 2 * edge <= GAP * radius) {
      ++crowd;
      edge *= 2;
    }
    return { colors: filled, crowd: this.pulled[crowd]!.texture, crowdEdge: edge };
  }

  private draw(level: Level, part: Rect): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, level.framebuffer);
    gl.viewport(0, 0, level.size.width, level.size.height);
    gl.scissor(part.x0, part.y0, part.x1 - part.x0, part.y1 - part.y0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
