// A scene in a headset, by WebXR: at human scale, on the floor before the one who looks.
import { Camera } from "./camera";
import { Box, Module, Vec3 } from "./module";
import { PosedEye } from "./posed_eye";
import type { Display, Player } from "./player";
import { DrawOptions, Renderer, ScenePart } from "./renderer/renderer";
import { WholeView, wholeView } from "./whole_view";

const METRES_TALL = [0.5, 3] as const;  // heights that are taken for metres
const HEIGHT = 1.7;    // metres, of what has another height
const AWAY = 1;        // metres from the head to the front of the scene
const NEAR = 0.05;     // metres
const MOVED = 0.02;    // of the distance: how far a head moves until other details are made ready
const SEEK_US = 1e6;
const SEEK_MS = 350;   // between seeks while the stick is held
const PUSHED = 0.6;

/** Where a scene stands in a room, whose floor is at y = 0. */
export class Room {
  /** Metres for a unit of the scene. */
  readonly scale: number;
  private readonly axes: [Vec3, Vec3, Vec3];
  private readonly foot: Vec3;
  private readonly back: number;

  constructor(private readonly module: Module, box: Box, up: number) {
    const axis = Math.abs(up) - 1, height = box.max[axis]! - box.min[axis]!;
    const isMetres = height >= METRES_TALL[0] && height <= METRES_TALL[1];
    this.scale = isMetres || !(height > 0) ? 1 : HEIGHT / height;
    this.axes = new Camera(module, up).seenFrom([0, 0, 0], 1).axes;
    this.foot = box.min.map((v, i) => (v + box.max[i]!) / 2) as Vec3;
    this.foot[axis] = up > 0 ? box.min[axis]! : box.max[axis]!;
    const depth = this.axes[2].reduce((sum, v, i) => sum + Math.abs(v) * (box.max[i]! - box.min[i]!), 0);
    this.back = AWAY + 0.5 * this.scale * depth;
  }

  direction(x: number, y: number, z: number): Vec3 {
    return [0, 1, 2].map((i) => x * this.axes[0][i]! + y * this.axes[1][i]! + z * this.axes[2][i]!) as Vec3;
  }
  /** Of the scene, for one of the room. */
  point(x: number, y: number, z: number): Vec3 {
    const from = this.direction(x, y, z + this.back);
    return this.foot.map((v, i) => v + from[i]! / this.scale) as Vec3;
  }
  eye(view: XRView): PosedEye {
    const m = view.transform.matrix, column = (i: number) => this.direction(m[i]!, m[i + 1]!, m[i + 2]!);
    return new PosedEye(this.module, view.projectionMatrix, this.point(m[12]!, m[13]!, m[14]!), [column(0), column(4), column(8)],
                        NEAR / this.scale);
  }
}

export class Headset implements Display {
  private frame: XRFrame | null = null;
  private room: Room | null = null;
  private seen: WholeView | null = null;
  private seenFrom: Vec3 = [0, 0, 0];
  private sought = 0;

  private constructor(private readonly player: Player, private readonly module: Module, private readonly session: XRSession,
                      private readonly space: XRReferenceSpace, private readonly layer: XRWebGLLayer, private readonly mode: XRSessionMode) {}

  /** Asks for a session, which a browser grants after a press of a button only. `ended` is called when it is over. */
  static async enter(mode: XRSessionMode, player: Player, renderer: Renderer, module: Module, ended: () => void): Promise<Headset> {
    if (!navigator.xr) throw new Error("this browser has no WebXR");
    const session = await navigator.xr.requestSession(mode, { requiredFeatures: ["local-floor"] });
    try {
      await renderer.gl.makeXRCompatible();
      const layer = new XRWebGLLayer(session, renderer.gl, { depth: false, antialias: false });
      await session.updateRenderState({ baseLayer: layer });
      const headset = new Headset(player, module, session, await session.requestReferenceSpace("local-floor"), layer, mode);
      session.addEventListener("end", ended, { once: true });
      session.addEventListener("select", () => (player.playing ? player.pause() : player.play()));
      headset.wait();
      return headset;
    } catch (error) {
      await session.end().catch(() => undefined);
      throw error;
    }
  }

  leave(): void { this.session.end().catch(() => undefined); }

  private wait(): void {
    this.session.requestAnimationFrame((time, frame) => {
      this.wait();
      this.frame = frame;
      this.followSticks(time);
      this.player.drawFrame();
      this.frame = null;
    });
  }

  /** Sticks to the left and right go back and forward. */
  private followSticks(time: number): void {
    let pushed = 0;
    for (const { gamepad } of this.session.inputSources) {
      const x = gamepad?.axes[2] ?? gamepad?.axes[0] ?? 0;
      if (Math.abs(x) > Math.abs(pushed)) pushed = x;
    }
    if (Math.abs(pushed) < PUSHED) this.sought = 0;
    else if (time - this.sought > SEEK_MS) {
      this.sought = time;
      this.player.seekBy(Math.sign(pushed) * SEEK_US);
    }
  }

  view(): WholeView | null {
    const pose = this.frame?.getViewerPose(this.space), box = this.player.bounds(), up = this.player.camera?.up;
    const view = pose?.views[0], port = view && this.layer.getViewport(view);
    if (!pose || !port || !box || up === undefined) return this.seen;
    this.room ??= new Room(this.module, box, up);
    const { x, y, z } = pose.transform.position, head = this.room.point(x, y, z);
    const moved = Math.hypot(...head.map((v, i) => v - this.seenFrom[i]!));
    if (this.seen && moved < MOVED * this.seen.camera.distance) return this.seen;
    this.seenFrom = head;
    // The frustum's height at depth 1 is 2 over this number.
    return (this.seen = wholeView(this.module, box, up, head, 0.5 * port.height * view.projectionMatrix[5]!));
  }

  draw(renderer: Renderer, parts: readonly ScenePart[], options: DrawOptions, reduction: number): number {
    const pose = this.frame?.getViewerPose(this.space), { room, layer } = this;
    if (!pose || !room) return 0;
    let drawn = 0;
    for (const view of pose.views) {
      const port = layer.getViewport(view);
      if (!port || port.width === 0 || port.height === 0) continue;
      const size = { width: Math.ceil(port.width / reduction), height: Math.ceil(port.height / reduction) };
      drawn = renderer.draw(parts, room.eye(view), size, { ...options, floor: null });
      renderer.present({ framebuffer: layer.framebuffer, x: port.x, y: port.y, width: port.width, height: port.height,
                         seeThrough: this.mode === "immersive-ar" });
    }
    return drawn;
  }
}
