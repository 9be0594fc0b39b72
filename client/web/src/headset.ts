// A scene in a headset, by WebXR: at human scale, on the floor before the one who looks.
import { Module } from "./module";
import type { Display, Player } from "./player";
import { DrawOptions, Renderer, ScenePart } from "./renderer/renderer";
import { Room } from "./room";
import { FollowingView, WholeView } from "./whole_view";

const AWAY = 1;        // metres from the head to the front of the scene
const NEAR = 0.05;     // metres
const SEEK_US = 1e6;
const SEEK_MS = 350;   // between seeks while the stick is held
const PUSHED = 0.6;

export class Headset implements Display {
  private frame: XRFrame | null = null;
  private room: Room | null = null;
  private readonly following = new FollowingView();
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
    if (!pose || !port || !box || up === undefined) return this.following.seen;
    this.room ??= new Room(this.module, box, up, AWAY);
    const { x, y, z } = pose.transform.position, head = this.room.point(x, y, z);
    // The frustum's height at depth 1 is 2 over this number.
    return this.following.follow(this.module, box, up, head, 0.5 * port.height * view.projectionMatrix[5]!);
  }

  draw(renderer: Renderer, parts: readonly ScenePart[], options: DrawOptions, reduction: number): number {
    const pose = this.frame?.getViewerPose(this.space), { room, layer } = this;
    if (!pose || !room) return 0;
    let drawn = 0;
    for (const view of pose.views) {
      const port = layer.getViewport(view);
      if (!port || port.width === 0 || port.height === 0) continue;
      const size = { width: Math.ceil(port.width / reduction), height: Math.ceil(port.height / reduction) };
      drawn = renderer.draw(parts, room.eye(view.transform.matrix, view.projectionMatrix, NEAR), size, { ...options, floor: null });
      renderer.present({ framebuffer: layer.framebuffer, x: port.x, y: port.y, width: port.width, height: port.height,
                         seeThrough: this.mode === "immersive-ar" });
    }
    return drawn;
  }
}
