// An eye whose matrices are given: one of a headset, or the camera of another scene.
import { Camera, Eye, Viewpoint } from "./camera";
import { Module, Vec3 } from "./module";

export class PosedEye implements Viewpoint {
  /**
   * `projection`: 16 numbers in columns, as OpenGL has them, of which the frustum's sides count. `position` and
   * `axes` (to the right, up and back) are in the scene's coordinates, as is `near`. `up`: as in PrCamera.
   */
  constructor(readonly module: Module, private readonly projection: ArrayLike<number>, private readonly position: Vec3,
              private readonly axes: [Vec3, Vec3, Vec3], private readonly near: number,
              private readonly up: number) {}

  get upright(): Float64Array {
    const camera = new Camera(this.module, this.up), front = camera.seenFrom([0, 0, 0], 1).axes, back = this.axes[2];
    const [x, y, z] = front.map((axis) => axis.reduce((sum, v, i) => sum + v * back[i]!, 0)) as Vec3;
    camera.state.set(this.position.map((v, i) => v - camera.distance * back[i]!));
    camera.state[4] = camera.state[5] = 0;
    camera.orbit(Math.atan2(x, z), Math.asin(Math.min(1, Math.max(-1, y))));
    return camera.state;
  }

  seenFrom(origin: Vec3): Eye {
    const p = this.projection, [right, up, back] = this.axes;
    const from = this.position.map((v, i) => v - origin[i]!);
    const toEye = (axis: Vec3) => [...axis, -axis.reduce((sum, v, i) => sum + v * from[i]!, 0)];
    const x = toEye(right), y = toEye(up), z = toEye(back);
    const toClip = new Float32Array(16);
    for (let column = 0; column < 4; ++column) {
      toClip[4 * column] = p[0]! * x[column]! + p[8]! * z[column]!;
      toClip[4 * column + 1] = p[5]! * y[column]! + p[9]! * z[column]!;
      toClip[4 * column + 3] = -z[column]!;
    }
    toClip[14] = this.near;
    return { toClip, near: this.near, eye: this.position, axes: this.axes,
             sides: { left: (p[8]! - 1) / p[0]!, right: (p[8]! + 1) / p[0]!,
                      bottom: (p[9]! - 1) / p[5]!, top: (p[9]! + 1) / p[5]! } };
  }
}
