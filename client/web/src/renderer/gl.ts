// Programs, textures and framebuffers of WebGL2.

export class DrawingError extends Error {}

/** Where the View block is bound: the last place that WebGL2 promises, for others who share a context count from 0. */
export const VIEW_BINDING = 23;
/** Where the Shading block is. */
export const SHADING_BINDING = 22;

/** A linked program. Samplers are bound to the texture units that the text asks for. */
export class Program {
  private readonly places = new Map<string, WebGLUniformLocation>();

  constructor(private readonly gl: WebGL2RenderingContext, private readonly program: WebGLProgram,
              units: ReadonlyMap<string, number>) {
    gl.useProgram(program);
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) as number;
    for (let i = 0; i < count; ++i) {
      const info = gl.getActiveUniform(program, i);
      const place = info && gl.getUniformLocation(program, info.name);
      if (!info || !place) continue;  // a member of a block
      this.places.set(info.name, place);
      const unit = units.get(info.name);
      if (unit !== undefined) gl.uniform1i(place, unit);
    }
    for (const [name, binding] of [["View", VIEW_BINDING], ["Shading", SHADING_BINDING]] as const) {
      const block = gl.getUniformBlockIndex(program, name);
      if (block !== gl.INVALID_INDEX) gl.uniformBlockBinding(program, block, binding);
    }
  }

  use(): void { this.gl.useProgram(this.program); }
  /** What the program does not use is ignored. */
  float(name: string, value: number): void {
    this.gl.uniform1f(this.places.get(name) ?? null, value);
  }
  int(name: string, value: number): void { this.gl.uniform1i(this.places.get(name) ?? null, value); }
  uint(name: string, value: number): void {
    this.gl.uniform1ui(this.places.get(name) ?? null, value);
  }
  /** An array. */
  vec2s(name: string, values: Float32Array): void { this.gl.uniform2fv(this.places.get(`${name}[0]`) ?? null, values); }
  vec4(name: string, x: number, y: number, z: number, w: number): void {
    this.gl.uniform4f(this.places.get(name) ?? null, x, y, z, w);
  }
  ivec2(name: string, x: number, y: number): void { this.gl.uniform2i(this.places.get(name) ?? null, x, y); }
  ivec4(name: string, x: number, y: number, z: number, w: number): void {
    this.gl.uniform4i(this.places.get(name) ?? null, x, y, z, w);
  }
}

export interface Texts {
  vertex: string;
  fragment: string;
  units: ReadonlyMap<string, number>;
}

/** A program that is compiled when it is first used, or before. */
export class LateProgram {
  private linking: { program: WebGLProgram; units: ReadonlyMap<string, number> } | null = null;
  private made: Program | null = null;

  constructor(private readonly gl: WebGL2RenderingContext, private readonly texts: () => Texts) {}

  get(): Program {
    this.made ??= this.finish();
    this.made.use();
    return this.made;
  }

  /** Lets the driver compile and link. To ask how that went would be to wait for it. */
  start(): void {
    if (this.linking) return;
    const { gl } = this, texts = this.texts(), program = gl.createProgram();
    if (!program) throw new DrawingError("the graphics driver has gone");
    for (const [type, text] of [[gl.VERTEX_SHADER, texts.vertex], [gl.FRAGMENT_SHADER, texts.fragment]] as const) {
      const shader = gl.createShader(type);
      if (!shader) throw new DrawingError("the graphics driver has gone");
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      gl.deleteShader(shader);
    }
    gl.linkProgram(program);
    this.linking = { program, units: texts.units };
  }

  free(): void {
    this.gl.deleteProgram(this.linking?.program ?? null);
    this.linking = this.made = null;
  }

  private finish(): Program {
    this.start();
    const { gl } = this, { program, units } = this.linking!;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = (gl.getAttachedShaders(program) ?? []).map((s) => gl.getShaderInfoLog(s) ?? "");
      const why = [...logs, gl.getProgramInfoLog(program) ?? ""].join(" ").trim();
      throw new DrawingError(`the graphics driver rejects a program: ${why.split("\n")[0]}`);
    }
    return new Program(gl, program, units);
  }
}

export interface Size {
  width: number;
  height: number;
}

export function makeTexture(gl: WebGL2RenderingContext, format: number, size: Size,
                            filter: number = gl.NEAREST): WebGLTexture {
  const texture = gl.createTexture();
  if (!texture) throw new DrawingError("the graphics driver has gone");
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, size.width, size.height);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return texture;
}

export function makeFramebuffer(gl: WebGL2RenderingContext, color: WebGLTexture,
                                depth?: WebGLTexture): WebGLFramebuffer {
  const framebuffer = gl.createFramebuffer();
  if (!framebuffer) throw new DrawingError("the graphics driver has gone");
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, color, 0);
  if (depth)
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depth, 0);
  const status = gl.checkFramebufferStatus(gl.FRAMEBUFFER);
  if (status !== gl.FRAMEBUFFER_COMPLETE && !gl.isContextLost())
    throw new DrawingError("the graphics driver has no memory for a picture of this size");
  return framebuffer;
}

export function bindTexture(gl: WebGL2RenderingContext, unit: number, texture: WebGLTexture): void {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, texture);
}
