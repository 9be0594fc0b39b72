// Lights the pixels of a picture once it is known what they show: client/render/opengl/late_light.h, which explains
// the passes. Its shaders and numbers are those of the desktop player.
import { Viewpoint } from "../camera";
import { COLORS, ColorSource, Light, LIGHTS, Module, Vec3 } from "../module";
import { bindTexture, makeFramebuffer, makeTexture, SHADING_BINDING, Size } from "./gl";
import { around, EMPTY, Rect } from "./region";
import { Programs } from "./shaders";

const SHADOW_EDGE = 256;
const GLOSSY_EDGE = 34;  // with the texel around it on each side
const TAPS = 12;
const SHADING_FLOATS = 88, TO_SHADOW = 16;  // ShadingView

export interface LightOptions {
  color: ColorSource;
  light: Light;
  lighting: boolean;
  roughness: number;
  /** A PrEnvironment, for that light. */
  environment: number;
}

/** Instances in coordinates relative to an origin. `bounds`: PrBounds. */
export interface Lit {
  origin: Vec3;
  bounds: Float64Array;
  /** Draws each as a GL point, with the program that is in use. */
  drawPoints(): void;
}

/** tap() of client/render/shading.h, for all turns. */
function makeTaps(): Float32Array {
  const taps = new Float32Array(2 * 4 * TAPS);
  for (let turn = 0; turn < 4; ++turn) {
    for (let i = 0; i < TAPS; ++i) {
      const away = Math.sqrt((i + 0.5 + 0.25 * turn) / (TAPS + 0.75)), angle = 2.39996323 * i + 0.6 * turn;
      taps.set([away * Math.cos(angle), away * Math.sin(angle)], 2 * (TAPS * turn + i));
    }
  }
  return taps;
}

/** The bounds of all, relative to the origin of the first. */
function boundsOfAll(parts: readonly Lit[]): Float64Array {
  const all = Float64Array.of(Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity, 0, 0, 0);
  for (const { origin, bounds } of parts) {
    for (let i = 0; i < 3; ++i) {
      const way = origin[i]! - parts[0]!.origin[i]!;
      all[i] = Math.min(all[i]!, bounds[i]! + way);
      all[3 + i] = Math.max(all[3 + i]!, bounds[3 + i]! + way);
    }
    all[6] = Math.max(all[6]!, bounds[6]!);
    all[7]! += bounds[7]!;
    all[8]! += bounds[8]!;
  }
  return all;
}

interface PictureTextures {
  normals: WebGLTexture;
  open: WebGLTexture;
  lit: WebGLTexture;
}
interface MapTextures {
  nearest: WebGLTexture;
  rows: WebGLTexture;
  moments: WebGLTexture;
  glossy: WebGLTexture;
}

export class LateLight {
  private picture: (PictureTextures & { toNormals: WebGLFramebuffer; toOpen: WebGLFramebuffer; toLit: WebGLFramebuffer }) | null = null;
  private map: (MapTextures & { toNearest: WebGLFramebuffer; toRows: WebGLFramebuffer; toMoments: WebGLFramebuffer }) | null = null;
  private depth: WebGLTexture | null = null;
  private size: Size = { width: 0, height: 0 };
  private region: Rect = EMPTY;
  private probe: { module: Module; handle: number; of: string } | null = null;
  private readonly block: WebGLBuffer;
  private readonly taps = makeTaps();
  private readonly filter: number;

  constructor(private readonly gl: WebGL2RenderingContext, private readonly programs: Programs) {
    this.block = gl.createBuffer()!;
    this.filter = gl.getExtension("OES_texture_float_linear") ? gl.LINEAR : gl.NEAREST;
  }

  free(): void {
    this.freePicture();
    const { gl, map } = this;
    this.freeProbe();
    gl.deleteBuffer(this.block);
    if (!map) return;
    for (const f of [map.toNearest, map.toRows, map.toMoments]) gl.deleteFramebuffer(f);
    for (const t of [map.nearest, map.rows, map.moments, map.glossy]) gl.deleteTexture(t);
    this.map = null;
  }
  private freeProbe(): void {
    this.probe?.module.call("pr_probe_free", this.probe.handle);
    this.probe = null;
  }
  private freePicture(): void {
    const { gl, picture } = this;
    this.picture = null;
    if (!picture) return;
    for (const f of [picture.toNormals, picture.toOpen, picture.toLit]) gl.deleteFramebuffer(f);
    for (const t of [picture.normals, picture.open, picture.lit]) gl.deleteTexture(t);
  }

  private resize(size: Size, depth: WebGLTexture): void {
    const { gl } = this;
    if (!this.map) {
      const edge = { width: SHADOW_EDGE, height: SHADOW_EDGE };
      const nearest = makeTexture(gl, gl.DEPTH_COMPONENT32F, edge), rows = makeTexture(gl, gl.RG32F, edge);
      const moments = makeTexture(gl, gl.RG32F, edge, this.filter);
      const glossy = makeTexture(gl, gl.RGB16F, { width: GLOSSY_EDGE, height: GLOSSY_EDGE }, gl.LINEAR);
      this.map = { nearest, rows, moments, glossy, toNearest: makeFramebuffer(gl, rows, nearest),
                   toRows: makeFramebuffer(gl, rows), toMoments: makeFramebuffer(gl, moments) };
    }
    if (this.picture && depth === this.depth && size.width === this.size.width && size.height === this.size.height) return;
    this.freePicture();
    const half = { width: (size.width + 1) >> 1, height: (size.height + 1) >> 1 };
    const normals = makeTexture(gl, gl.RGBA16F, size), open = makeTexture(gl, gl.RGBA32F, half), lit = makeTexture(gl, gl.RGBA16F, size);
    this.picture = { normals, open, lit, toNormals: makeFramebuffer(gl, normals, depth), toOpen: makeFramebuffer(gl, open),
                     toLit: makeFramebuffer(gl, lit) };
    this.depth = depth;
    this.size = { ...size };
    this.region = EMPTY;
  }

  /**
   * Begins a picture: draws what the key light sees of the parts, of which there is at least one. `depth` is that of the
   * picture. Other passes are in the coordinates of the first part. Changes the viewport, the bound framebuffer, and with
   * light the depth test.
   */
  begin(size: Size, depth: WebGLTexture, parts: readonly Lit[], viewpoint: Viewpoint, options: LightOptions): void {
    const { module } = viewpoint, { light, lighting, roughness } = options;
    this.resize(size, depth);
    const probe = light === "flat" ? 0 : this.probeOf(module, light === "environment" ? options.environment : 0, roughness);
    const [camera, bounds] = module.put(viewpoint.upright, boundsOfAll(parts)), origin = parts[0]!.origin;
    const shading = module.floats(module.call("pr_shading", camera!, bounds!, ...origin, COLORS.indexOf(options.color),
                                              LIGHTS.indexOf(light), Number(lighting), roughness, probe), SHADING_FLOATS);
    if (light !== "flat") this.drawShadow(parts, shading);
    this.upload(shading);
  }
  private probeOf(module: Module, environment: number, roughness: number): number {
    const { gl } = this, of = `${environment} ${roughness}`;
    if (this.probe?.of === of) return this.probe.handle;
    this.freeProbe();
    this.probe = { module, handle: module.made("pr_probe_new", environment, roughness), of };
    const texels = module.floats(module.call("pr_probe_glossy", this.probe.handle), 3 * GLOSSY_EDGE * GLOSSY_EDGE);
    bindTexture(gl, 0, this.map!.glossy);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, GLOSSY_EDGE, GLOSSY_EDGE, gl.RGB, gl.FLOAT, texels);
    return this.probe.handle;
  }
  private upload(shading: Float32Array): void {
    const { gl } = this;
    gl.bindBufferBase(gl.UNIFORM_BUFFER, SHADING_BINDING, this.block);
    gl.bufferData(gl.UNIFORM_BUFFER, shading, gl.DYNAMIC_DRAW);
  }

  private drawShadow(parts: readonly Lit[], shading: Float32Array): void {
    const { gl } = this, map = this.map!;
    gl.bindFramebuffer(gl.FRAMEBUFFER, map.toNearest);
    gl.viewport(0, 0, SHADOW_EDGE, SHADOW_EDGE);
    gl.clearBufferfv(gl.DEPTH, 0, [0]);
    gl.colorMask(false, false, false, false);
    this.programs.shadow.get();
    for (const part of parts) {
      this.upload(shadingFrom(shading, part.origin.map((v, i) => v - parts[0]!.origin[i]!)));
      part.drawPoints();
    }
    gl.colorMask(true, true, true, true);
    gl.disable(gl.DEPTH_TEST);
    const blur = this.programs.shadowBlur.get();
    for (const [from, to, along, nearest] of [[map.nearest, map.toRows, [1, 0], 1], [map.rows, map.toMoments, [0, 1], 0]] as const) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, to);
      bindTexture(gl, 0, from);
      blur.ivec2("along", along[0], along[1]);
      blur.int("nearest", nearest);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.viewport(0, 0, this.size.width, this.size.height);
    gl.enable(gl.DEPTH_TEST);
  }

  /** Darkens the bound framebuffer where it shows the floor in the shadow of the scene. */
  shadeFloor(): void {
    const { gl } = this;
    this.programs.floorShadow.get();
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.FUNC_ADD);
    gl.blendFuncSeparate(gl.ZERO, gl.SRC_COLOR, gl.ZERO, gl.ONE);
    bindTexture(gl, 0, this.map!.moments);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
  }

  /** The framebuffer of sums of 0.5 + 0.5 n, for normals n, and of weights, empty in a region. Leaves it bound. */
  bindNormals(region: Rect): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.picture!.toNormals);
    scissor(gl, region);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.disable(gl.SCISSOR_TEST);
  }

  /**
   * Lights the sums of colours and weights of a picture, which are empty outside of the region, and whose normals were
   * drawn. Depth test and blending must be off. Returns lit sums.
   */
  light(sums: WebGLTexture, region: Rect): WebGLTexture {
    const { gl, size } = this, { normals, open, lit, toOpen, toLit } = this.picture!, map = this.map!;
    bindTexture(gl, 0, sums);
    bindTexture(gl, 1, normals);
    bindTexture(gl, 2, this.depth!);
    // Neighbours of squares at the rim are looked at, too.
    scissor(gl, { x0: (region.x0 >> 1) - 1, y0: (region.y0 >> 1) - 1, x1: ((region.x1 + 1) >> 1) + 1, y1: ((region.y1 + 1) >> 1) + 1 });
    this.programs.open.get().vec2s("taps", this.taps);
    gl.bindFramebuffer(gl.FRAMEBUFFER, toOpen);
    gl.viewport(0, 0, (size.width + 1) >> 1, (size.height + 1) >> 1);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    this.programs.light.get();
    bindTexture(gl, 3, open);
    bindTexture(gl, 4, map.moments);
    bindTexture(gl, 5, map.glossy);
    gl.bindFramebuffer(gl.FRAMEBUFFER, toLit);
    gl.viewport(0, 0, size.width, size.height);
    scissor(gl, around(this.region, region));
    this.region = region;
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
    return lit;
  }
}

function scissor(gl: WebGL2RenderingContext, { x0, y0, x1, y1 }: Rect): void {
  gl.enable(gl.SCISSOR_TEST);
  gl.scissor(Math.max(x0, 0), Math.max(y0, 0), Math.max(x1 - Math.max(x0, 0), 0), Math.max(y1 - Math.max(y0, 0), 0));
}

/** The same map of the key light, for coordinates relative to an origin that is so far away. */
function shadingFrom(shading: Float32Array, away: readonly number[]): Float32Array {
  const moved = shading.slice();
  for (let row = 0; row < 3; ++row)
    for (let column = 0; column < 3; ++column)
      moved[TO_SHADOW + 12 + row]! += shading[TO_SHADOW + 4 * column + row]! * away[column]!;
  return moved;
}
