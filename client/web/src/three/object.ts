// A reel, or live streams, as an object of a three.js scene.
import * as THREE from "three";
import type { PointreelObject as Declared, PointreelObjectEventMap } from "../../package/three";
import { Mode, Vec3 } from "../module";
import { Display, Player, SharedContext } from "../player";
import { DrawOptions, Renderer, ScenePart } from "../renderer/renderer";
import { Room } from "../room";
import { placesOf, sourcesOf } from "../sources";
import { FollowingView, WholeView } from "../whole_view";
import fragmentShader from "./composite.frag.glsl";
import vertexShader from "./composite.vert.glsl";

/** What a camera of three.js sees of the object. */
interface Eye {
  camera: THREE.Camera;
  /** From the eye to the object's coordinates, with axes of length 1. */
  pose: number[];
  near: number;
}

/** Gives the player pictures for the camera that three.js renders with. */
class CameraDisplay implements Display {
  eye: Eye | null = null;
  readonly viewport = new THREE.Vector4();
  private room: Room | null = null;
  private roomOf: unknown = null;
  private following = new FollowingView();

  constructor(private readonly player: Player) {}

  /** The room where what is open stands; null before its size is known. */
  place(): Room | null {
    const { player } = this, box = player.bounds();
    if (!player.camera || !box) return null;
    // That of a reel never changes; live streams move in theirs.
    const of = player.reel ?? player.live[0];
    if (of !== this.roomOf) {
      this.room = new Room(player.camera.module, box, player.camera.up, null);
      this.roomOf = of;
      this.following = new FollowingView();
    }
    return this.room;
  }

  view(): WholeView | null {
    const room = this.place(), { eye, player } = this, box = player.bounds();
    if (!eye || !room || !box || !player.camera) return this.following.seen;
    const [x, y, z] = eye.pose.slice(12), from = room.point(x!, y!, z!);
    const pixels = 0.5 * this.viewport.w * eye.camera.projectionMatrix.elements[5]!;
    return this.following.follow(player.camera.module, box, player.camera.up, from, pixels);
  }

  draw(renderer: Renderer, parts: readonly ScenePart[], options: DrawOptions, reduction: number): number {
    const { eye, room, viewport } = this;
    if (!eye || !room) return 0;
    const size = { width: Math.ceil(viewport.z / reduction), height: Math.ceil(viewport.w / reduction) };
    const viewpoint = room.eye(eye.pose, eye.camera.projectionMatrix.elements, eye.near);
    const drawn = renderer.draw(parts, viewpoint, size, { ...options, floor: null });
    this.onPicture(renderer);
    return drawn;
  }
  onPicture: (renderer: Renderer) => void = () => undefined;

  leave(): void {}
}

class ThreeContext implements SharedContext {
  readonly gl: WebGL2RenderingContext;
  constructor(private readonly three: THREE.WebGLRenderer) { this.gl = three.getContext(); }

  use<Result>(act: () => Result): Result {
    const { three } = this, { state } = three, isReversed = state.buffers.depth.getReversed();
    const target = three.getRenderTarget(), face = three.getActiveCubeFace(), level = three.getActiveMipmapLevel();
    const viewport = three.getCurrentViewport(new THREE.Vector4());
    three.resetState();
    try {
      return act();
    } finally {
      three.resetState();
      state.buffers.depth.setReversed(isReversed);
      three.setRenderTarget(target, face, level);
      // That of one of several eyes is not the target's.
      state.viewport(viewport);
    }
  }
}

/** The interface is that of package/three.d.ts. */
export class PointreelObject extends THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial, PointreelObjectEventMap> implements Declared {
  private readonly player: Player;
  private readonly context: ThreeContext;
  private readonly display: CameraDisplay;
  private readonly color = new THREE.ExternalTexture();
  private readonly depth = new THREE.ExternalTexture();

  constructor(renderer: THREE.WebGLRenderer, { base = new URL("./", import.meta.url) }: { base?: string | URL } = {}) {
    const triangle = new THREE.BufferGeometry();
    triangle.setAttribute("position", new THREE.BufferAttribute(Float32Array.of(-1, -1, 0, 3, -1, 0, -1, 3, 0), 3));
    super(triangle, new THREE.ShaderMaterial({
      vertexShader, fragmentShader, toneMapped: false,
      uniforms: { color: { value: null }, depth: { value: null }, near: { value: 0 } },
    }));
    this.frustumCulled = false;
    this.context = new ThreeContext(renderer);
    this.player = new Player(renderer.domElement, new URL(base, document.baseURI), this.context);
    this.display = new CameraDisplay(this.player);
    this.display.onPicture = (drawing) => {
      this.color.sourceTexture = drawing.textures!.color;
      this.depth.sourceTexture = drawing.textures!.depth;
      drawing.leave();
    };
    this.player.display = this.display;
    this.player.onEvent = (type) => this.dispatchEvent({ type });
    const { uniforms } = this.material;
    uniforms.color!.value = this.color;
    uniforms.depth!.value = this.depth;
    this.onBeforeRender = (by, _scene, camera) => this.drawFor(by, camera);
  }

  async load(source: string, { loop = false, token = "", places = "" } = {}): Promise<void> {
    await this.player.open(sourcesOf(source), token || null, { loop, startUs: 0, places: placesOf(places) });
    if (this.player.error) throw new Error(this.player.error);
  }
  play(): void { this.player.play(); }
  pause(): void { this.player.pause(); }
  dispose(): void {
    this.player.free();
    this.geometry.dispose();
    this.material.dispose();
  }

  get paused(): boolean { return !this.player.playing; }
  get duration(): number { return this.player.duration; }
  get currentTime(): number { return (this.player.reel?.clock.read().positionUs ?? 0) / 1e6; }
  set currentTime(seconds: number) { this.player.seek(Math.max(0, seconds) * 1e6); }
  get playbackRate(): number { return this.player.speed; }
  set playbackRate(rate: number) { this.player.setSpeed(rate); }
  get volume(): number { return this.player.volume; }
  set volume(volume: number) { this.player.setVolume(volume, this.muted); }
  get muted(): boolean { return this.player.muted; }
  set muted(muted: boolean) { this.player.setVolume(this.volume, muted); }
  get mode(): Mode { return this.player.settings.mode; }
  set mode(mode: Mode) { this.player.set({ mode }); }
  get lighting(): boolean { return this.player.settings.lighting; }
  set lighting(lighting: boolean) { this.player.set({ lighting }); }
  get frame(): number { return this.player.frame; }
  get error(): string | null { return this.player.trouble; }
  get size(): Vec3 | null { return this.display.place()?.size ?? null; }

  /** A ray hits nothing: the triangle of this mesh covers the whole picture. */
  raycast(): void {}

  /** Draws the picture that this mesh then puts into the scene. */
  private drawFor(three: THREE.WebGLRenderer, camera: THREE.Camera): void {
    if (!camera.isPerspectiveCamera) throw new Error("Pointreel draws for perspective cameras only");
    const { elements } = new THREE.Matrix4().copy(this.matrixWorld).invert().multiply(camera.matrixWorld);
    const scale = Math.hypot(elements[0]!, elements[1]!, elements[2]!);
    const pose = elements.map((value, i) => (i < 12 ? value / scale : value));
    this.display.eye = { camera, pose, near: camera.near * scale };
    this.material.uniforms.near!.value = camera.near;
    three.getCurrentViewport(this.display.viewport);
    this.context.use(() => this.player.drawFrame());
  }
}
