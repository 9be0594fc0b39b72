// The View block of common.glsl: from where a picture is seen.
import { Eye } from "../camera";
import { Vec3 } from "../module";
import { Size, VIEW_BINDING } from "./gl";

const FLOATS = 44, LIGHT_AT = 23;
/** Draws 0.5 + 0.5 n in place of colours, for normals n. */
export const SHOW_NORMALS = 2;
const LIGHT = normalize([-0.35, 0.45, 1]);  // in eye space, over the viewer's left shoulder

function normalize(v: Vec3): Vec3 {
  const length = Math.hypot(...v);
  return [v[0] / length, v[1] / length, v[2] / length];
}

export class ViewBlock {
  private readonly buffer: WebGLBuffer;

  constructor(private readonly gl: WebGL2RenderingContext) { this.buffer = gl.createBuffer()!; }

  free(): void { this.gl.deleteBuffer(this.buffer); }
  bind(): void { this.gl.bindBufferBase(this.gl.UNIFORM_BUFFER, VIEW_BINDING, this.buffer); }

  /** `light`: its strength, 0 without lighting, or SHOW_NORMALS. `unsigned`: the signs of normals are unknown. */
  set(eye: Eye, origin: Vec3, size: Size, light: number, unsigned: boolean): void {
    const { left, right: rightSide, bottom, top } = eye.sides, [right, up, back] = eye.axes;
    const stepX = (rightSide - left) / size.width, stepY = (top - bottom) / size.height;
    const toLight = [0, 1, 2].map((i) => LIGHT[0] * right[i]! + LIGHT[1] * up[i]! + LIGHT[2] * back[i]!);
    const corner = [0, 1, 2].map((i) => -back[i]! + left * right[i]! + bottom * up[i]!);
    const view = new Float32Array(FLOATS);
    view.set(eye.toClip);
    view.set([...eye.eye.map((v, i) => v - origin[i]!), eye.near, ...toLight, light,
              stepY, unsigned ? 1 : 0, 0, 0, ...corner, 0, ...right.map((c) => stepX * c), 0,
              ...up.map((c) => stepY * c), 0, size.width, size.height, 0, 0], 16);
    this.upload(view);
  }
  setLight(light: number): void {
    this.gl.bindBuffer(this.gl.UNIFORM_BUFFER, this.buffer);
    this.gl.bufferSubData(this.gl.UNIFORM_BUFFER, 4 * LIGHT_AT, Float32Array.of(light));
  }
  /** For programs that ask for nothing but where the picture is shown. */
  setWindow({ x, y, width, height }: Size & { x: number; y: number }): void {
    const view = new Float32Array(FLOATS);
    view.set([width, height, x, y], 40);
    this.upload(view);
  }

  private upload(view: Float32Array): void {
    this.gl.bindBuffer(this.gl.UNIFORM_BUFFER, this.buffer);
    this.gl.bufferData(this.gl.UNIFORM_BUFFER, view, this.gl.DYNAMIC_DRAW);
  }
}
