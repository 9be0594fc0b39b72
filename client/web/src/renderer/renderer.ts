// Draws scenes with WebGL2, as client/render does with OpenGL 4.5 and by the same shaders.
import { Camera, Eye } from "../camera";
import { Box, isEmpty, Mode, Module, Packed, Vec3 } from "../module";
import { bindTexture, DrawingError, makeFramebuffer, makeTexture, Size } from "./gl";
import { InstanceTexture } from "./instances";
import { Filling, Reconstruction } from "./reconstruction";
import { around, EMPTY, isNone, Place, Rect } from "./region";
import { LateProgram } from "./gl";
import { makePrograms, Programs } from "./shaders";

export interface DrawOptions {
  mode: Mode;
  lighting: boolean;
  fillHoles: boolean;
  smoothOutlines: boolean;
  /** Edge of a point in pixels of the picture. */
  pointSize: number;
  /** sRGB, 0 to 1. */
  background: Vec3;
  /** Draw a grid on the floor of this box. */
  floor: Box | null;
}

export interface ScenePart {
  packed: Packed;
}

const SCALE = 1.4;  // of surfels: SplatScales
const DEPTH_TOLERANCE = 1;
const CUBE_CORNER = 1.7321;
const CUBE_REACH = 1.73206, SURFEL_REACH = 1.41422;  // voxel_mark.glsl, surfel_mark.glsl
const LARGEST_SPRITE = 48, NEAREST_SPRITE = 0.015;  // mark.glsl
const LIGHT = normalize([-0.35, 0.45, 1]);  // in eye space, over the viewer's left shoulder
const VIEW_FLOATS = 44;  // the View block of common.glsl
const PICK_REACH = 8;

function normalize(v: Vec3): Vec3 {
  const length = Math.hypot(...v);
  return [v[0] / length, v[1] / length, v[2] / length];
}
const linearFromSrgb = (c: number) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const minus = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

interface Drawable {
  instances: InstanceTexture;
  packed: Packed;
  view: WebGLBuffer;
  place: Place;
  eye: Eye;
  /** Some instances may be too large for GL points. */
  hasSolids: boolean;
}

export class Renderer {
  private readonly gl: WebGL2RenderingContext;
  private readonly programs: Programs;
  private readonly reconstruction: Reconstruction;
  private readonly noAttributes: WebGLVertexArrayObject;
  private readonly floorArray: WebGLVertexArrayObject;
  private readonly floorLines: WebGLBuffer;
  private readonly floorView: WebGLBuffer;
  private readonly views: WebGLBuffer[] = [];
  private readonly textures: InstanceTexture[] = [];
  private readonly uploaded: (Packed | null)[] = [];
  private size: Size = { width: 0, height: 0 };
  private targets: Targets | null = null;
  private summed: Rect = EMPTY;
  private drawn: { camera: Float64Array; eye: Eye } | null = null;
  private region: Rect = EMPTY;
  private smooth = false;

  constructor(readonly canvas: HTMLCanvasElement, private readonly module: Module) {
    const gl = canvas.getContext("webgl2", {
      alpha: false, antialias: false, depth: false, stencil: false,
      powerPreference: "high-performance",
    }) as WebGL2RenderingContext | null;
    if (!gl) throw new DrawingError("this browser has no WebGL2, which is needed to draw");
    this.gl = gl;
    if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
      throw new DrawingError("this graphics driver cannot draw in floating point");
    gl.getExtension("EXT_float_blend");
    const clip = gl.getExtension("EXT_clip_control") as
      { clipControlEXT(origin: number, depth: number): void; LOWER_LEFT_EXT: number; ZERO_TO_ONE_EXT: number } | null;
    clip?.clipControlEXT(clip.LOWER_LEFT_EXT, clip.ZERO_TO_ONE_EXT);
    this.programs = makePrograms(gl, clip !== null);
    this.reconstruction = new Reconstruction(gl, this.programs);
    this.noAttributes = gl.createVertexArray()!;
    this.floorLines = gl.createBuffer()!;
    this.floorView = gl.createBuffer()!;
    this.floorArray = this.makeFloorArray();
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
  }

  get isLost(): boolean { return this.gl.isContextLost(); }
  get driver(): string {
    const names = this.gl.getExtension("WEBGL_debug_renderer_info");
    return String(this.gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : this.gl.RENDERER));
  }
  get largestSide(): number { return this.gl.getParameter(this.gl.MAX_TEXTURE_SIZE) as number; }

  /** Returns how many instances were drawn. */
  draw(parts: readonly ScenePart[], camera: Camera, size: Size, options: DrawOptions): number {
    const { gl } = this;
    this.resize(size);
    const targets = this.targets!;
    const drawables = this.prepare(parts, camera, options);
    this.drawn = { camera: camera.state.slice(), eye: camera.seenFrom([0, 0, 0], this.aspect) };
    this.smooth = options.smoothOutlines;
    this.region = EMPTY;
    gl.viewport(0, 0, size.width, size.height);
    gl.colorMask(true, true, true, true);
    gl.depthMask(true);
    gl.depthFunc(gl.GREATER);
    gl.enable(gl.DEPTH_TEST);
    for (const off of [gl.BLEND, gl.CULL_FACE, gl.SCISSOR_TEST]) gl.disable(off);
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.picture);
    const [r, g, b] = options.background.map(linearFromSrgb) as Vec3;
    gl.clearBufferfv(gl.COLOR, 0, [r, g, b, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [0]);
    const floor = options.floor && this.floor(options.floor, camera, options);
    if (floor?.isBelow) floor.draw();
    if (drawables.length > 0) {
      gl.bindVertexArray(this.noAttributes);
      if (options.mode === "surfel") this.drawSurfels(drawables, options);
      else if (options.mode === "voxel") this.drawVoxels(drawables);
      else this.drawPoints(drawables, options.pointSize);
    }
    if (floor && !floor.isBelow) floor.draw();
    return drawables.reduce((sum, d) => sum + d.packed.count, 0);
  }

  /** Shows the last picture on the canvas, whose size may be another. */
  present(): void {
    const { gl } = this, targets = this.targets;
    if (!targets) return;
    const { width, height } = this.canvas;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    for (const off of [gl.BLEND, gl.CULL_FACE, gl.SCISSOR_TEST, gl.DEPTH_TEST]) gl.disable(off);
    gl.colorMask(true, true, true, true);
    gl.bindVertexArray(this.noAttributes);
    this.bindView(targets.presentView, { width, height });
    this.programs.present.get();
    bindTexture(gl, 0, targets.color);
    const filter = width === this.size.width && height === this.size.height ? gl.NEAREST : gl.LINEAR;
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    if (!this.smooth || filter === gl.LINEAR || isNone(this.region)) return;
    const r = this.region, program = this.programs.outlines.get();
    program.ivec4("region", r.x0, r.y0, r.x1 - 1, r.y1 - 1);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(r.x0, r.y0, r.x1 - r.x0, r.y1 - r.y0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
  }

  /** Renderer::point_at, with x and y from the upper left corner, 0 to 1 across the picture. */
  pointAt(x: number, y: number): Vec3 | null {
    const { gl, drawn, targets, size } = this;
    if (!drawn || !targets || !(x >= 0 && x <= 1 && y >= 0 && y <= 1)) return null;
    const at = [x * size.width, (1 - y) * size.height] as const;
    const middle = [Math.min(Math.floor(at[0]), size.width - 1), Math.min(Math.floor(at[1]), size.height - 1)] as const;
    const first = [Math.max(middle[0] - PICK_REACH, 0), Math.max(middle[1] - PICK_REACH, 0)] as const;
    const edge = 2 * PICK_REACH + 1;
    const program = this.programs.depthBits.get();
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.pick);
    gl.viewport(0, 0, edge, edge);
    for (const off of [gl.BLEND, gl.DEPTH_TEST, gl.SCISSOR_TEST]) gl.disable(off);
    gl.bindVertexArray(this.noAttributes);
    bindTexture(gl, 0, targets.depth);
    program.ivec4("first", first[0], first[1], 0, 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const bits = new Uint32Array(4 * edge * edge);
    gl.readPixels(0, 0, edge, edge, gl.RGBA_INTEGER, gl.UNSIGNED_INT, bits);
    const depths = new Float32Array(bits.buffer);
    let nearest = PICK_REACH + 0.5, found: readonly [number, number] | null = null, depth = 0;
    for (let i = 0; i < edge * edge; ++i) {
      const here = [first[0] + (i % edge), first[1] + Math.floor(i / edge)] as const;
      const away = Math.hypot(here[0] - middle[0], here[1] - middle[1]);
      if (here[0] >= size.width || here[1] >= size.height || !(depths[4 * i]! > 0) || away >= nearest) continue;
      nearest = away;
      depth = depths[4 * i]!;
      found = away === 0 ? at : [here[0] + 0.5, here[1] + 0.5];
    }
    if (!found) return null;
    const { eye, near, axes, fovY } = drawn.eye, t = Math.tan(0.5 * fovY), away = near / depth;
    const across = t * (2 * found[0] - size.width) / size.height, up = t * (2 * found[1] - size.height) / size.height;
    return [0, 1, 2].map((i) => eye[i]! + away * (across * axes[0][i]! + up * axes[1][i]! - axes[2][i]!)) as Vec3;
  }

  free(): void { this.gl.getExtension("WEBGL_lose_context")?.loseContext(); }

  private get aspect(): number { return this.size.width / this.size.height; }

  private resize(size: Size): void {
    if (this.targets && size.width === this.size.width && size.height === this.size.height) return;
    this.targets?.free();
    this.size = { ...size };
    this.targets = new Targets(this.gl, size);
    this.summed = { x0: 0, y0: 0, x1: size.width, y1: size.height };
    this.reconstruction.resize(size);
  }

  /** Uploads what is new, and computes how each part is seen. */
  private prepare(parts: readonly ScenePart[], camera: Camera, options: DrawOptions): Drawable[] {
    const { gl, size } = this, drawables: Drawable[] = [];
    parts.forEach(({ packed }, i) => {
      this.textures[i] ??= new InstanceTexture(gl);
      this.views[i] ??= gl.createBuffer()!;
      if (this.uploaded[i] !== packed) this.textures[i]!.upload(packed);
      this.uploaded[i] = packed;
      if (packed.count === 0) return;
      const eye = camera.seenFrom(packed.origin, this.aspect);
      const place = new Place(this.module, packed.bounds, eye.toClip, size.width, size.height);
      this.setView(this.views[i]!, eye, packed.origin, options.lighting, packed.normalsEstimated);
      drawables.push({ instances: this.textures[i]!, packed, view: this.views[i]!, place, eye,
                       hasSolids: this.mayHaveSolids(place, eye, options.mode) });
    });
    for (let i = parts.length; i < this.textures.length; ++i) {
      this.textures[i]!.free();
      this.uploaded[i] = null;
    }
    return drawables;
  }

  /** False if kind_of in mark.glsl certainly finds no solid. */
  private mayHaveSolids(place: Place, eye: Eye, mode: Mode): boolean {
    const radius = (mode === "voxel" ? CUBE_REACH : SURFEL_REACH * SCALE) * place.largestRadius;
    const nearest = place.nearest(eye.near), step = 2 * Math.tan(0.5 * eye.fovY) / this.size.height;
    // The distance of an instance in the picture is at most this many times its depth.
    const slant = Math.hypot(1, Math.tan(0.5 * eye.fovY) * Math.hypot(1, this.aspect));
    if (radius > NEAREST_SPRITE * nearest) return true;
    if (2 * radius * slant > LARGEST_SPRITE * step * nearest) return true;
    const r = place.region(0, 0);
    // region() adds a pixel on each side.
    return r.x0 <= 0 || r.y0 <= 0 || r.x1 >= this.size.width || r.y1 >= this.size.height;
  }

  private setView(buffer: WebGLBuffer, eye: Eye, origin: Vec3, lighting: boolean, unsigned: boolean): void {
    const { gl, size } = this, slope = Math.tan(0.5 * eye.fovY), step = 2 * slope / size.height;
    const [right, up, back] = eye.axes;
    const toLight = [0, 1, 2].map((i) => LIGHT[0] * right[i]! + LIGHT[1] * up[i]! + LIGHT[2] * back[i]!);
    const corner = [0, 1, 2].map((i) => -back[i]! - 0.5 * step * size.width * right[i]! - slope * up[i]!);
    const view = new Float32Array(VIEW_FLOATS);
    view.set(eye.toClip);
    view.set([...minus(eye.eye, origin), eye.near, ...toLight, lighting ? 1 : 0,
              step, unsigned ? 1 : 0, 0, 0, ...corner, 0, ...right.map((c) => step * c), 0,
              ...up.map((c) => step * c), 0, size.width, size.height, 0, 0], 16);
    gl.bindBuffer(gl.UNIFORM_BUFFER, buffer);
    gl.bufferData(gl.UNIFORM_BUFFER, view, gl.DYNAMIC_DRAW);
  }
  /** A View block that knows only the size. */
  private bindView(buffer: WebGLBuffer, size: Size): void {
    const { gl } = this, view = new Float32Array(VIEW_FLOATS);
    view.set([size.width, size.height], 40);
    gl.bindBuffer(gl.UNIFORM_BUFFER, buffer);
    gl.bufferData(gl.UNIFORM_BUFFER, view, gl.DYNAMIC_DRAW);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, buffer);
  }

  private bind(part: Drawable): void {
    this.gl.bindBufferBase(this.gl.UNIFORM_BUFFER, 0, part.view);
    part.instances.bind();
  }

  private drawBoth(part: Drawable, programs: { sprites: LateProgram; solids: LateProgram },
                   reach: number, scale: number, tolerance: number, verticesPerSolid: number): void {
    const { gl } = this;
    this.bind(part);
    for (const program of [programs.sprites, programs.solids]) {
      if (program === programs.solids && !part.hasSolids) break;
      const used = program.get();
      used.float("largest_scale", reach);
      used.float("scale", scale);
      used.float("tolerance", tolerance);
      if (program === programs.sprites) gl.drawArrays(gl.POINTS, 0, part.packed.count);
      else gl.drawArrays(gl.TRIANGLES, 0, verticesPerSolid * part.packed.count);
    }
  }

  private drawPoints(parts: readonly Drawable[], size: number): void {
    const { gl } = this, program = this.programs.point.get();
    program.float("size", Math.max(1, size));
    for (const part of parts) {
      this.bind(part);
      gl.drawArrays(gl.POINTS, 0, part.packed.count);
      this.region = around(this.region, part.place.region(0, Math.ceil(0.5 * size)));
    }
  }

  private drawVoxels(parts: readonly Drawable[]): void {
    const { gl } = this;
    gl.enable(gl.CULL_FACE);
    for (const part of parts) {
      this.drawBoth(part, this.programs.voxel, 1, 1, 0, 18);
      this.region = around(this.region, part.place.region(CUBE_CORNER, 1));
    }
    gl.disable(gl.CULL_FACE);
  }

  private drawSurfels(parts: readonly Drawable[], options: DrawOptions): void {
    const { gl } = this, targets = this.targets!;
    for (const part of parts) this.region = around(this.region, part.place.region(1.5 * SCALE, 0));
    const region = this.region;
    const signsUnknown = parts.some((part) => part.packed.normalsEstimated);
    gl.enable(gl.CULL_FACE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.splats);
    gl.colorMask(false, false, false, false);
    for (const part of parts) {
      this.drawBoth(part, this.programs.surfelDepth, SCALE, SCALE, DEPTH_TOLERANCE, 6);
      if (options.fillHoles && !signsUnknown) this.reconstruction.drawBacks(part.packed.count);
    }
    gl.colorMask(true, true, true, true);
    gl.depthMask(false);
    this.scissor(around(this.summed, region));
    this.summed = region;
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.disable(gl.SCISSOR_TEST);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.FUNC_ADD);
    gl.blendFunc(gl.ONE, gl.ONE);
    for (const part of parts) this.drawBoth(part, this.programs.surfelSum, SCALE, SCALE, 0, 6);
    gl.disable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    const filling = options.fillHoles && !isNone(region)
      ? this.fillHoles(parts, region, signsUnknown) : null;
    const resolve = this.programs.resolve.get();
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.resolved);
    bindTexture(gl, 0, targets.sums);
    bindTexture(gl, 1, filling?.colors ?? targets.sums);
    bindTexture(gl, 2, targets.depth);
    bindTexture(gl, 3, filling?.crowd ?? targets.sums);
    resolve.int("fill", filling ? 1 : 0);
    resolve.float("crowd_edge", Math.max(filling?.crowdEdge ?? 1, 1));
    this.scissor(region);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
  }

  private fillHoles(parts: readonly Drawable[], region: Rect, signsUnknown: boolean): Filling {
    const { gl } = this, targets = this.targets!;
    const count = parts.reduce((sum, part) => sum + part.place.count, 0);
    if (signsUnknown) {
      const radius = parts.reduce((sum, part) => sum + part.place.radii, 0) / Math.max(count, 1);
      const nearest = Math.min(...parts.map((part) => part.place.nearest(part.eye.near)));
      gl.bindFramebuffer(gl.FRAMEBUFFER, targets.onlySums);
      this.scissor(region);
      this.reconstruction.clearSeeThrough(targets.depth, radius, nearest);
      gl.disable(gl.SCISSOR_TEST);
    }
    const pixels = Math.max(...parts.map((part) => part.place.radiusInPixels()));
    return this.reconstruction.fill(targets.sums, region, pixels, this.size);
  }

  private scissor(r: Rect): void {
    this.gl.enable(this.gl.SCISSOR_TEST);
    this.gl.scissor(r.x0, r.y0, Math.max(r.x1 - r.x0, 0), Math.max(r.y1 - r.y0, 0));
  }

  private makeFloorArray(): WebGLVertexArrayObject {
    const { gl } = this, array = gl.createVertexArray()!;
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.floorLines);
    for (const [place, size, offset] of [[0, 3, 0], [1, 3, 12], [2, 2, 24]] as const) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 32, offset);
      gl.vertexAttribDivisor(place, 1);
    }
    return array;
  }

  private floor(box: Box, camera: Camera, options: DrawOptions): { isBelow: boolean; draw(): void } | null {
    if (isEmpty(box)) return null;
    const { gl, module } = this;
    const [state, bounds] = module.put(camera.state, Float64Array.of(...box.min, ...box.max));
    const lines = module.call("pr_floor_lines", state!, bounds!);
    const count = module.call("pr_floor_line_count");
    const place = module.doubles(module.call("pr_floor_origin"), 4);
    const data = module.floats(lines, 8 * count);
    const origin: Vec3 = [place[0]!, place[1]!, place[2]!];
    const axis = Math.abs(camera.up) - 1, sign = Math.sign(camera.up);
    const eye = camera.seenFrom(origin, this.aspect);
    const draw = () => {
      if (count === 0) return;
      this.setView(this.floorView, eye, origin, options.lighting, false);
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets!.picture);
      gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, this.floorView);
      gl.bindVertexArray(this.floorArray);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.floorLines);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
      const program = this.programs.floor.get();
      const [r, g, b] = options.background.map(linearFromSrgb) as Vec3;
      const isDark = 0.2126 * r + 0.7152 * g + 0.0722 * b < 0.18, light = isDark ? 1 : 0;
      program.vec4("line_color", light, light, light, isDark ? 0.16 : 0.5);
      program.float("reach", place[3]!);
      program.int("up_axis", axis);
      gl.disable(gl.DEPTH_TEST);
      gl.enable(gl.BLEND);
      gl.blendEquation(gl.FUNC_ADD);
      gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
      gl.disable(gl.BLEND);
      gl.enable(gl.DEPTH_TEST);
    };
    return { isBelow: sign * (eye.eye[axis]! - origin[axis]!) >= 0, draw };
  }
}

/** What is drawn into, in the size of the picture. */
class Targets {
  readonly color: WebGLTexture;
  readonly depth: WebGLTexture;
  readonly sums: WebGLTexture;
  readonly picture: WebGLFramebuffer;
  readonly resolved: WebGLFramebuffer;
  readonly splats: WebGLFramebuffer;
  readonly onlySums: WebGLFramebuffer;
  readonly pick: WebGLFramebuffer;
  readonly presentView: WebGLBuffer;
  private readonly picked: WebGLTexture;

  constructor(private readonly gl: WebGL2RenderingContext, size: Size) {
    this.color = makeTexture(gl, gl.SRGB8_ALPHA8, size);
    this.depth = makeTexture(gl, gl.DEPTH_COMPONENT32F, size);
    this.sums = makeTexture(gl, gl.RGBA16F, size);
    this.picked = makeTexture(gl, gl.RGBA32UI, { width: 2 * PICK_REACH + 1, height: 2 * PICK_REACH + 1 });
    this.picture = makeFramebuffer(gl, this.color, this.depth);
    this.resolved = makeFramebuffer(gl, this.color);
    this.splats = makeFramebuffer(gl, this.sums, this.depth);
    this.onlySums = makeFramebuffer(gl, this.sums);
    this.pick = makeFramebuffer(gl, this.picked);
    this.presentView = gl.createBuffer()!;
  }
  free(): void {
    const { gl } = this;
    for (const f of [this.picture, this.resolved, this.splats, this.onlySums, this.pick]) gl.deleteFramebuffer(f);
    for (const t of [this.color, this.depth, this.sums, this.picked]) gl.deleteTexture(t);
    gl.deleteBuffer(this.presentView);
  }
}
