import { Box, Module, Vec3 } from "./module";

/** How an eye sees. */
export interface Eye {
  /** From the scene to clip coordinates, with reversed depth. */
  toClip: Float32Array;
  near: number;
  eye: Vec3;
  /** To the right, up and back. */
  axes: [Vec3, Vec3, Vec3];
  /** Where the picture's sides are at depth 1, to the right and up of the direction of view. */
  sides: { left: number; right: number; bottom: number; top: number };
}

/** From where a picture is drawn. */
export interface Viewpoint {
  /** Computes where in the picture things lie. */
  readonly module: Module;
  /** PrCamera, of somebody who looks from there in the same direction and holds his head upright. */
  readonly upright: Float64Array;
  /** Relative to an origin near the scene, for pictures of this width over height. */
  seenFrom(origin: Vec3, aspect: number): Eye;
}

const NAMED: Record<string, [number, number]> = {
  front: [0, 0], back: [Math.PI, 0], left: [-Math.PI / 2, 0], right: [Math.PI / 2, 0],
  top: [0, Math.PI / 2], bottom: [0, -Math.PI / 2],
};
export type NamedView = keyof typeof NAMED;
/** Yaw and pitch of a named view or of "YAW,PITCH" in degrees; null for anything else. */
export function directionOf(text: string): [number, number] | null {
  if (Object.keys(NAMED).includes(text)) return NAMED[text]!;
  const angles = text.split(",").map((part) => (part.trim() === "" ? NaN : (Number(part) * Math.PI) / 180));
  return angles.length === 2 && angles.every(Number.isFinite) ? [angles[0]!, angles[1]!] : null;
}

const UPS = ["-z", "-y", "-x", "", "x", "y", "z"];
/** The axis that points up, as PrCamera has it; null for what is none. */
export function upOf(text: string): number | null {
  const at = text === "" ? -1 : UPS.indexOf(text);
  return at < 0 ? null : at - 3;
}

/** A camera of client/scene/camera.h, whose functions the module has. */
export class Camera implements Viewpoint {
  /** PrCamera: target, distance, yaw, pitch, fov_y, scene_radius, up. */
  readonly state = new Float64Array(9);

  constructor(readonly module: Module, up = 2) { this.change("pr_camera_init", up); }

  private change(name: string, ...args: number[]): void {
    const [at] = this.module.put(this.state);
    this.module.call(name, at!, ...args);
    this.state.set(this.module.doubles(at!, 9));
  }

  get upright(): Float64Array { return this.state; }
  get up(): number { return this.state[8]!; }
  get distance(): number { return this.state[3]!; }
  get yaw(): number { return this.state[4]!; }
  get pitch(): number { return this.state[5]!; }
  get fovY(): number { return this.state[6]!; }
  get radius(): number { return this.state[7]!; }

  private show(name: string, box: Box, ...args: number[]): void {
    const [at, bounds] = this.module.put(this.state, Float64Array.of(...box.min, ...box.max));
    this.module.call(name, at!, bounds!, ...args);
    this.state.set(this.module.doubles(at!, 9));
  }
  frameBounds(box: Box, aspect: number): void { this.show("pr_camera_frame_bounds", box, aspect); }
  /** From where it looks now. `covered`: the share of the picture's height, at its bottom, that is to stay free. */
  fit(box: Box, aspect: number, covered: number): void { this.show("pr_camera_fit", box, aspect, covered); }
  orbit(yaw: number, pitch: number): void { this.change("pr_camera_orbit", yaw, pitch); }
  pan(right: number, up: number): void { this.change("pr_camera_pan", right, up); }
  zoom(factor: number): void { this.change("pr_camera_zoom", factor); }
  zoomAt(factor: number, x: number, y: number, aspect: number): void {
    this.change("pr_camera_zoom_at", factor, x, y, aspect);
  }
  centerOn(point: Vec3): void { this.change("pr_camera_center_on", ...point); }

  lookFrom(view: NamedView): void { this.lookAlong(NAMED[view]!); }
  lookAlong([yaw, pitch]: readonly [number, number]): void {
    this.state[4] = this.state[5] = 0;
    this.orbit(yaw, pitch);
  }
  /** The eye stays where it is, and only the picture turns over. */
  turnOver(): void {
    this.state[8] = -this.up;
    this.state[4] = Math.PI - this.yaw;
    this.state[5] = -this.pitch;
  }

  seenFrom(origin: Vec3, aspect: number): Eye {
    const slope = Math.tan(0.5 * this.fovY), across = slope * aspect;
    const [at] = this.module.put(this.state);
    const m = this.module.floats(this.module.call("pr_camera_matrices", at!, ...origin, aspect), 49);
    const a = this.module.doubles(this.module.call("pr_camera_axes", at!), 12);
    const v = (i: number): Vec3 => [a[i]!, a[i + 1]!, a[i + 2]!];
    return { toClip: m.slice(32, 48), near: m[48]!, eye: v(0), axes: [v(3), v(6), v(9)],
             sides: { left: -across, right: across, bottom: -slope, top: slope } };
  }
}
