// Draws scenes with WebGL2, as client/render does with OpenGL 4.5 and by the same shaders.
import { Camera, Eye, Viewpoint } from "../camera";
import { isShadedLate } from "../colors";
import { Box, ColorSource, Light, Mode, Packed, Vec3 } from "../module";
import { DepthReader } from "./depth_reader";
import { Floor, FloorLines, floorLines } from "./floor";
import { bindTexture, DrawingError, LateProgram, Size } from "./gl";
import { IndexBuffer, InstanceTexture } from "./instances";
import { LateLight, Lit } from "./late_light";
import { Filling, Reconstruction } from "./reconstruction";
import { around, EMPTY, isNone, Place, Rect } from "./region";
import { freePrograms, makePrograms, Programs } from "./shaders";
import { Targets } from "./targets";
import { SHOW_NORMALS, ViewBlock } from "./view_block";

export interface DrawOptions {
  mode: Mode;
  color: ColorSource;
  light: Light;
  roughness: number;
  /** A PrEnvironment, for that light. */
  environment: number;
  /** With flat light. */
  lighting: boolean;
  fillHoles: boolean;
  smoothOutlines: boolean;
  /** The least edge of a point, and the largest, in pixels of the picture. If that is less, all have the least. */
  pointSize: number;
  largestPoint: number;
  /** sRGB, 0 to 1. */
  background: Vec3;
  /** Draw a grid on the floor of this box, as a camera sees it. */
  floor: { box: Box; camera: Camera } | null;
}

/** The part of a framebuffer where a picture is shown; null is the canvas. */
export interface Surface extends Size {
  framebuffer: WebGLFramebuffer | null;
  x: number;
  y: number;
  seeThrough: boolean;
}

export interface ScenePart {
  packed: Packed;
}

const SCALE = 1.4;  // of surfels: SplatScales
const DEPTH_TOLERANCE = 1;
const CUBE_CORNER = 1.7321;
const CUBE_REACH = 1.73206, SURFEL_REACH = 1.41422;  // voxel_mark.glsl, surfel_mark.glsl
const LARGEST_SPRITE = 48, NEAREST_SPRITE = 0.015;  // mark.glsl

const linearFromSrgb = (c: number) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);

interface Drawable {
  instances: InstanceTexture;
  indices: IndexBuffer;
  packed: Packed;
  view: ViewBlock;
  place: Place;
  eye: Eye;
  /** Some instances may be too large for GL points. */
  hasSolids: boolean;
}

/** A context for a renderer alone. */
export function contextOf(canvas: HTMLCanvasElement): WebGL2RenderingContext {
  const gl = canvas.getContext("webgl2", {
    alpha: false, antialias: false, depth: false, stencil: false,
    powerPreference: "high-performance",
  }) as WebGL2RenderingContext | null;
  if (!gl) throw new DrawingError("this browser has no WebGL2, which is needed to draw");
  return gl;
}

interface ClipControl {
  clipControlEXT(origin: number, depth: number): void;
  readonly LOWER_LEFT_EXT: number;
  readonly NEGATIVE_ONE_TO_ONE_EXT: number;
  readonly ZERO_TO_ONE_EXT: number;
}

/**
 * Draws with a context that may be shared. Its state must then be as at its creation when draw() is called, and
 * leave() must be called before others go on.
 */
export class Renderer {
  private readonly clip: ClipControl | null;
  private readonly programs: Programs;
  private readonly reconstruction: Reconstruction;
  private readonly noAttributes: WebGLVertexArrayObject;
  private readonly floor: Floor;
  private readonly depthReader: DepthReader;
  private readonly lateLight: LateLight | null;
  private readonly lateView: ViewBlock;
  private readonly views: ViewBlock[] = [];
  private readonly presentView: ViewBlock;
  private readonly instances: InstanceTexture[] = [];
  private readonly indices: IndexBuffer[] = [];
  private readonly uploaded: (Packed | null)[] = [];
  private size: Size = { width: 0, height: 0 };
  private targets: Targets | null = null;
  private summed: Rect = EMPTY;
  /** From where the last picture is seen. */
  private eye: Eye | null = null;
  private region: Rect = EMPTY;
  private smooth = false;

  constructor(readonly gl: WebGL2RenderingContext) {
    const hasFloats = gl.getExtension("EXT_color_buffer_float") !== null;
    if (!hasFloats && !gl.getExtension("EXT_color_buffer_half_float"))
      throw new DrawingError("this graphics driver cannot draw in floating point");
    gl.getExtension("EXT_float_blend");
    this.clip = gl.getExtension("EXT_clip_control") as ClipControl | null;
    this.programs = makePrograms(gl, this.clip !== null);
    this.reconstruction = new Reconstruction(gl, this.programs);
    this.noAttributes = gl.createVertexArray()!;
    this.presentView = new ViewBlock(gl);
    this.floor = new Floor(gl, this.programs.floor);
    this.depthReader = new DepthReader(gl, this.programs.depthBits);
    this.lateLight = hasFloats ? new LateLight(gl, this.programs) : null;
    this.lateView = new ViewBlock(gl);
  }

  /**
   * Lets the driver compile what pictures of this kind need. It does so beside everything else, as
   * long as nobody asks for the result.
   */
  startCompiling({ mode, color, light, fillHoles, smoothOutlines, floor }:
                 Pick<DrawOptions, "mode" | "color" | "light" | "fillHoles" | "smoothOutlines"> & { floor: boolean }): void {
    const p = this.programs, needed = [p.present], late = this.lateLight && isShadedLate(color, light);
    if (late) needed.push(p.open, p.light, p.resolve);
    if (late && light !== "flat") needed.push(p.shadow, p.shadowBlur, ...(floor ? [p.floorShadow] : []));
    if (mode === "point") needed.push(p.point);
    else if (mode === "strip") needed.push(p.strip, p.point, ...(fillHoles ? [p.stripDepth, p.resolve] : []));
    else if (mode === "voxel") needed.push(p.voxel.sprites, p.voxel.solids);
    else needed.push(p.surfelDepth.sprites, p.surfelSum.sprites, p.surfelDepth.solids, p.surfelSum.solids, p.resolve);
    if (mode === "surfel" && fillHoles) needed.push(p.back);
    if ((mode === "surfel" || mode === "strip") && fillHoles) needed.push(p.pullSums, p.pull, p.push);
    if (smoothOutlines) needed.push(p.outlines);
    if (floor) needed.push(p.floor);
    for (const program of needed) program.start();
  }

  /** Whether pictures can have light and false colours; without, they are flat. */
  get canShade(): boolean { return this.lateLight !== null; }
  get isLost(): boolean { return this.gl.isContextLost(); }
  get driver(): string {
    const names = this.gl.getExtension("WEBGL_debug_renderer_info");
    return String(this.gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : this.gl.RENDERER));
  }
  get largestSide(): number { return this.gl.getParameter(this.gl.MAX_TEXTURE_SIZE) as number; }

  /** Returns how many instances were drawn. */
  draw(parts: readonly ScenePart[], viewpoint: Viewpoint, size: Size, options: DrawOptions): number {
    const { gl, clip } = this;
    clip?.clipControlEXT(clip.LOWER_LEFT_EXT, clip.ZERO_TO_ONE_EXT);
    this.resize(size);
    const targets = this.targets!;
    const drawables = this.prepare(parts, viewpoint, options);
    const late = drawables.length > 0 && isShadedLate(options.color, options.light) ? this.lateLight : null;
    this.eye = viewpoint.seenFrom([0, 0, 0], this.aspect);
    this.smooth = options.smoothOutlines;
    this.region = EMPTY;
    gl.viewport(0, 0, size.width, size.height);
    gl.colorMask(true, true, true, true);
    gl.depthMask(true);
    gl.depthFunc(gl.GREATER);
    gl.enable(gl.DEPTH_TEST);
    for (const off of [gl.BLEND, gl.CULL_FACE, gl.SCISSOR_TEST]) gl.disable(off);
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.picture);
    const background = options.background.map(linearFromSrgb) as Vec3;
    gl.clearBufferfv(gl.COLOR, 0, [...background, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [0]);
    if (late) {
      this.beginLate(late, drawables, viewpoint, options);
      gl.bindFramebuffer(gl.FRAMEBUFFER, targets.picture);
    }
    const floor = options.floor && floorLines(options.floor.box, options.floor.camera);
    const drawFloor = (lines: FloorLines) => {
      this.floor.draw(lines, viewpoint, size, background);
      if (!late || options.light === "flat") return;
      gl.bindVertexArray(this.noAttributes);
      this.lateView.bind();
      late.shadeFloor();
    };
    if (floor?.isBelow) drawFloor(floor);
    if (drawables.length > 0) {
      gl.bindVertexArray(this.noAttributes);
      if (options.mode === "surfel") this.drawSurfels(drawables, options, late);
      else if (options.mode === "strip") this.drawStrips(drawables, options, late);
      else this.drawElements(drawables, options, late);
    }
    if (floor && !floor.isBelow) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, targets.picture);
      drawFloor(floor);
    }
    return drawables.reduce((sum, d) => sum + d.packed.count, 0);
  }

  /** Shows the last picture on the canvas or on another surface, whose size may be another. */
  present(surface: Surface = { framebuffer: null, x: 0, y: 0, width: this.gl.canvas.width, height: this.gl.canvas.height,
                               seeThrough: false }): void {
    const { gl } = this, targets = this.targets;
    if (!targets) return;
    const { width, height } = surface;
    gl.bindFramebuffer(gl.FRAMEBUFFER, surface.framebuffer);
    gl.viewport(surface.x, surface.y, width, height);
    for (const off of [gl.BLEND, gl.CULL_FACE, gl.SCISSOR_TEST, gl.DEPTH_TEST]) gl.disable(off);
    gl.colorMask(true, true, true, true);
    gl.bindVertexArray(this.noAttributes);
    this.presentView.setWindow(surface);
    this.presentView.bind();
    this.programs.present.get().int("see_through", Number(surface.seeThrough));
    bindTexture(gl, 0, targets.color);
    const filter = width === this.size.width && height === this.size.height ? gl.NEAREST : gl.LINEAR;
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    // Outlines are smoothed where pixels of the picture are those of the surface.
    if (!this.smooth || filter === gl.LINEAR || surface.framebuffer || surface.seeThrough || isNone(this.region)) return;
    const r = this.region, program = this.programs.outlines.get();
    program.ivec4("region", r.x0, r.y0, r.x1 - 1, r.y1 - 1);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(r.x0, r.y0, r.x1 - r.x0, r.y1 - r.y0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
  }

  /** Renderer::point_at, with x and y from the upper left corner, 0 to 1 across the picture. */
  pointAt(x: number, y: number): Vec3 | null {
    const { targets, size } = this;
    if (!this.eye || !targets || !(x >= 0 && x <= 1 && y >= 0 && y <= 1)) return null;
    this.gl.bindVertexArray(this.noAttributes);
    const seen = this.depthReader.nearest(targets.depth, size, x * size.width, (1 - y) * size.height);
    if (!seen) return null;
    const { eye, near, axes, sides } = this.eye, away = near / seen.depth;
    const across = sides.left + (sides.right - sides.left) * seen.x / size.width;
    const up = sides.bottom + (sides.top - sides.bottom) * seen.y / size.height;
    return [0, 1, 2].map((i) => eye[i]! + away * (across * axes[0][i]! + up * axes[1][i]! - axes[2][i]!)) as Vec3;
  }

  /**
   * The last picture: linear colours with alpha 1 where something was drawn and 0 elsewhere, and depths, which are the
   * near plane's distance over that of the surface, or 0 where there is none.
   */
  get textures(): { color: WebGLTexture; depth: WebGLTexture } | null { return this.targets; }

  /** Leaves a shared context to others. */
  leave(): void {
    this.clip?.clipControlEXT(this.clip.LOWER_LEFT_EXT, this.clip.NEGATIVE_ONE_TO_ONE_EXT);
    this.gl.bindVertexArray(null);
  }

  /** Frees what it has made in the context. */
  free(): void {
    this.targets?.free();
    this.targets = null;
    this.reconstruction.free();
    for (const owner of [...this.instances, ...this.indices]) owner.free();
    for (const view of [...this.views, this.presentView, this.lateView]) view.free();
    this.lateLight?.free();
    this.floor.free();
    this.depthReader.free();
    freePrograms(this.programs);
    this.gl.deleteVertexArray(this.noAttributes);
  }

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
  private prepare(parts: readonly ScenePart[], viewpoint: Viewpoint, options: DrawOptions): Drawable[] {
    const { gl, size } = this, drawables: Drawable[] = [];
    const isLate = this.lateLight !== null && isShadedLate(options.color, options.light);
    parts.forEach(({ packed }, i) => {
      this.instances[i] ??= new InstanceTexture(gl);
      this.views[i] ??= new ViewBlock(gl);
      this.indices[i] ??= new IndexBuffer(gl);
      if (this.uploaded[i] !== packed) {
        this.instances[i]!.upload(packed);
        this.indices[i]!.upload(packed);
      }
      this.uploaded[i] = packed;
      if (packed.count === 0) return;
      const eye = viewpoint.seenFrom(packed.origin, this.aspect);
      const place = new Place(viewpoint.module, packed.bounds, eye.toClip, size.width, size.height);
      this.views[i]!.set(eye, packed.origin, size, options.lighting && !isLate ? packed.light : 0, packed.normalsEstimated);
      drawables.push({ instances: this.instances[i]!, indices: this.indices[i]!, packed, view: this.views[i]!, place, eye,
                       hasSolids: this.mayHaveSolids(place, eye, options.mode) });
    });
    for (let i = parts.length; i < this.instances.length; ++i) {
      this.instances[i]!.free();
      this.indices[i]!.free();
      this.uploaded[i] = null;
    }
    return drawables;
  }

  /** False if kind_of in mark.glsl certainly finds no solid. */
  private mayHaveSolids(place: Place, eye: Eye, mode: Mode): boolean {
    const radius = (mode === "voxel" ? CUBE_REACH : SURFEL_REACH * SCALE) * place.largestRadius;
    const { left, right, bottom, top } = eye.sides;
    const nearest = place.nearest(eye.near), step = (top - bottom) / this.size.height;
    // The distance of an instance in the picture is at most this many times its depth.
    const slant = Math.hypot(1, Math.max(-left, right), Math.max(-bottom, top));
    if (radius > NEAREST_SPRITE * nearest) return true;
    if (2 * radius * slant > LARGEST_SPRITE * step * nearest) return true;
    const r = place.region(0, 0);
    // region() adds a pixel on each side.
    return r.x0 <= 0 || r.y0 <= 0 || r.x1 >= this.size.width || r.y1 >= this.size.height;
  }

  /** The light's passes are in the coordinates of the first part. */
  private beginLate(late: LateLight, parts: readonly Drawable[], viewpoint: Viewpoint, options: DrawOptions): void {
    const { gl } = this, [{ eye, packed }] = parts as [Drawable];
    this.lateView.set(eye, packed.origin, this.size, 0, false);
    this.lateView.bind();
    gl.bindVertexArray(this.noAttributes);
    late.begin(this.size, this.targets!.depth, parts.map((part): Lit => ({
      origin: part.packed.origin, bounds: part.packed.bounds,
      drawPoints: () => {
        part.instances.bind();
        gl.drawArrays(gl.POINTS, 0, part.packed.count);
      },
    })), viewpoint, options);
  }
  private bindNormals(late: LateLight, parts: readonly Drawable[], region: Rect): void {
    for (const part of parts) part.view.setLight(SHOW_NORMALS);
    late.bindNormals(region);
  }

  private bind(part: Drawable): void {
    part.view.bind();
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

  private drawPoints(parts: readonly Drawable[], size: number, largest: number): void {
    const { gl } = this, program = this.programs.point.get();
    program.float("size", Math.max(1, size));
    program.float("largest", largest);
    for (const part of parts) {
      this.bind(part);
      gl.drawArrays(gl.POINTS, 0, part.packed.count);
    }
  }

  private drawVoxels(parts: readonly Drawable[]): void {
    const { gl } = this;
    gl.enable(gl.CULL_FACE);
    for (const part of parts) {
      this.drawBoth(part, this.programs.voxel, 1, 1, 0, 18);
    }
    gl.disable(gl.CULL_FACE);
  }

  /** Voxels or points. */
  private drawElements(parts: readonly Drawable[], options: DrawOptions, late: LateLight | null): void {
    const { gl } = this, isVoxel = options.mode === "voxel";
    for (const { place } of parts)
      this.region = around(this.region, isVoxel ? place.region(CUBE_CORNER, 1) : place.region(1, Math.ceil(0.5 * options.pointSize)));
    const draw = () => (isVoxel ? this.drawVoxels(parts) : this.drawPoints(parts, options.pointSize, options.largestPoint));
    if (!late) return draw();
    const region = this.region;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets!.splats);
    this.clearSums(region);
    draw();
    this.bindNormals(late, parts, region);
    gl.depthFunc(gl.GEQUAL);
    draw();
    gl.depthFunc(gl.GREATER);
    this.resolve(parts, { ...options, fillHoles: false }, region, false, late);
  }

  private drawSurfels(parts: readonly Drawable[], options: DrawOptions, late: LateLight | null): void {
    const { gl } = this, targets = this.targets!;
    for (const part of parts) this.region = around(this.region, part.place.region(1.5 * SCALE, 0));
    const region = this.region;
    const signsUnknown = parts.some((part) => part.packed.normalsEstimated);
    gl.enable(gl.CULL_FACE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.splats);
    gl.colorMask(false, false, false, false);
    for (const part of parts) {
      this.drawBoth(part, this.programs.surfelDepth, SCALE, SCALE, DEPTH_TOLERANCE, 6);
      if (options.fillHoles && !signsUnknown) this.reconstruction.drawBacks(part.packed.count, part.packed.oneBackIn);
    }
    gl.colorMask(true, true, true, true);
    gl.depthMask(false);
    this.clearSums(region);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.FUNC_ADD);
    gl.blendFunc(gl.ONE, gl.ONE);
    const sum = () => { for (const part of parts) this.drawBoth(part, this.programs.surfelSum, SCALE, SCALE, 0, 6); };
    sum();
    if (late) {
      this.bindNormals(late, parts, region);
      sum();
    }
    gl.disable(gl.BLEND);
    gl.disable(gl.CULL_FACE);
    this.resolve(parts, options, region, signsUnknown, late);
  }

  /** As StripPasses: triangles, of which those that are turned away only hide what is behind a hole. */
  private drawStrips(parts: readonly Drawable[], options: DrawOptions, late: LateLight | null): void {
    const { gl } = this, targets = this.targets!, sums = options.fillHoles || late !== null;
    for (const part of parts) this.region = around(this.region, part.place.region(0, 1));
    const region = this.region;
    const signsUnknown = parts.some((part) => part.packed.normalsEstimated);
    gl.bindFramebuffer(gl.FRAMEBUFFER, sums ? targets.splats : targets.picture);
    if (sums) this.clearSums(region);
    if (options.fillHoles && !signsUnknown) {
      gl.enable(gl.CULL_FACE);
      gl.colorMask(false, false, false, false);
      gl.cullFace(gl.FRONT);
      this.programs.stripDepth.get();
      for (const part of parts) {
        const { facing, mixed, turnedAway } = part.packed;
        this.bind(part);
        part.indices.draw(facing, mixed + turnedAway);
      }
      gl.cullFace(gl.BACK);
      gl.colorMask(true, true, true, true);
    }
    this.drawFronts(parts, signsUnknown);
    if (late) {
      this.bindNormals(late, parts, region);
      gl.depthFunc(gl.GEQUAL);
      this.drawFronts(parts, signsUnknown);
      gl.depthFunc(gl.GREATER);
    }
    if (sums) this.resolve(parts, options, region, signsUnknown, late);
  }
  private drawFronts(parts: readonly Drawable[], signsUnknown: boolean): void {
    const { gl } = this;
    if (!signsUnknown) gl.enable(gl.CULL_FACE);
    this.programs.strip.get();
    for (const part of parts) {
      this.bind(part);
      part.indices.draw(0, part.packed.facing + part.packed.mixed);
    }
    gl.disable(gl.CULL_FACE);
    gl.bindVertexArray(this.noAttributes);
    const points = this.programs.point.get();
    points.float("size", 1);
    points.float("largest", 0);
    for (const part of parts) {
      const { count, points: last } = part.packed;
      if (last === 0) continue;
      this.bind(part);
      gl.drawArrays(gl.POINTS, count - last, last);
    }
  }

  private clearSums(region: Rect): void {
    this.scissor(around(this.summed, region));
    this.summed = region;
    this.gl.clearBufferfv(this.gl.COLOR, 0, [0, 0, 0, 0]);
    this.gl.disable(this.gl.SCISSOR_TEST);
  }

  /** Makes the picture of the sums, which are lit if that is late. */
  private resolve(parts: readonly Drawable[], options: DrawOptions, region: Rect, signsUnknown: boolean,
                  late: LateLight | null): void {
    const { gl } = this, targets = this.targets!;
    gl.disable(gl.DEPTH_TEST);
    const fills = options.fillHoles && !isNone(region);
    if (fills && signsUnknown) this.clearSeeThrough(parts, region);
    let { sums } = targets;
    if (late) {
      this.lateView.bind();
      sums = late.light(sums, region);
    }
    const filling = fills ? this.fillHoles(parts, sums, region) : null;
    const resolve = this.programs.resolve.get();
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.resolved);
    bindTexture(gl, 0, sums);
    bindTexture(gl, 1, filling?.colors ?? sums);
    bindTexture(gl, 2, targets.depth);
    bindTexture(gl, 3, filling?.crowd ?? sums);
    resolve.int("fill", filling ? 1 : 0);
    resolve.float("crowd_edge", Math.max(filling?.crowdEdge ?? 1, 1));
    this.scissor(region);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
  }

  private clearSeeThrough(parts: readonly Drawable[], region: Rect): void {
    const { gl } = this, targets = this.targets!;
    const count = parts.reduce((sum, part) => sum + part.place.count, 0);
    const radius = parts.reduce((sum, part) => sum + part.place.radii, 0) / Math.max(count, 1);
    const nearest = Math.min(...parts.map((part) => part.place.nearest(part.eye.near)));
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.onlySums);
    this.scissor(region);
    this.reconstruction.clearSeeThrough(targets.depth, radius, nearest);
    gl.disable(gl.SCISSOR_TEST);
  }
  private fillHoles(parts: readonly Drawable[], sums: WebGLTexture, region: Rect): Filling {
    const pixels = Math.max(...parts.map((part) => part.place.radiusInPixels()));
    return this.reconstruction.fill(sums, region, pixels, this.size);
  }

  private scissor(r: Rect): void {
    this.gl.enable(this.gl.SCISSOR_TEST);
    this.gl.scissor(r.x0, r.y0, Math.max(r.x1 - r.x0, 0), Math.max(r.y1 - r.y0, 0));
  }
}
