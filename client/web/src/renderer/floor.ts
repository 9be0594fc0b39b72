// The grid on the floor: client/render/opengl/floor.h.
import { Camera, Viewpoint } from "../camera";
import { Box, isEmpty, Vec3 } from "../module";
import { LateProgram, Size } from "./gl";
import { ViewBlock } from "./view_block";

/** The luminance below which a background counts as dark. */
const DARK = 0.18;

export interface FloorLines {
  data: Float32Array;
  count: number;
  origin: Vec3;
  reach: number;
  upAxis: number;
  /** The floor is below the eye, so that what stands on it hides it. */
  isBelow: boolean;
}

/** The lines that a camera sees of the floor of `box`; null if it has none. */
export function floorLines(box: Box, camera: Camera): FloorLines | null {
  const { module } = camera;
  if (isEmpty(box)) return null;
  const [state, bounds] = module.put(camera.state, Float64Array.of(...box.min, ...box.max));
  const lines = module.call("pr_floor_lines", state!, bounds!);
  const count = module.call("pr_floor_line_count");
  if (count === 0) return null;
  const place = module.doubles(module.call("pr_floor_origin"), 4);
  const data = module.floats(lines, 8 * count), origin: Vec3 = [place[0]!, place[1]!, place[2]!];
  const upAxis = Math.abs(camera.up) - 1, { eye } = camera.seenFrom(origin, 1);
  const isBelow = Math.sign(camera.up) * (eye[upAxis]! - origin[upAxis]!) >= 0;
  return { data, count, origin, reach: place[3]!, upAxis, isBelow };
}

export class Floor {
  private readonly array: WebGLVertexArrayObject;
  private readonly buffer: WebGLBuffer;
  private readonly view: ViewBlock;

  constructor(private readonly gl: WebGL2RenderingContext, private readonly program: LateProgram) {
    this.view = new ViewBlock(gl);
    this.buffer = gl.createBuffer()!;
    this.array = gl.createVertexArray()!;
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    for (const [place, size, offset] of [[0, 3, 0], [1, 3, 12], [2, 2, 24]] as const) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 32, offset);
      gl.vertexAttribDivisor(place, 1);
    }
  }

  free(): void {
    this.gl.deleteVertexArray(this.array);
    this.gl.deleteBuffer(this.buffer);
    this.view.free();
  }

  /** Into the bound framebuffer. `background` is linear. */
  draw(lines: FloorLines, viewpoint: Viewpoint, size: Size, background: Vec3): void {
    const { gl } = this, [r, g, b] = background;
    this.view.set(viewpoint.seenFrom(lines.origin, size.width / size.height), lines.origin, size, 0, false);
    this.view.bind();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, lines.data, gl.DYNAMIC_DRAW);
    const program = this.program.get();
    const isDark = 0.2126 * r + 0.7152 * g + 0.0722 * b < DARK, light = isDark ? 1 : 0;
    program.vec4("line_color", light, light, light, isDark ? 0.16 : 0.5);
    program.float("reach", lines.reach);
    program.int("up_axis", lines.upAxis);
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.FUNC_ADD);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lines.count);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
  }
}
