// An eye whose matrices are given: one of a headset, or the camera of another scene.
import { Eye, Viewpoint } from "./camera";
import { Module, Vec3 } from "./module";

export class PosedEye implements Viewpoint {
  /**
   * `projection`: 16 numbers in columns, as OpenGL has them, of which the frustum's sides count. `position` and
   * `axes` (to the right, up and back) are in the scene's coordinates, as is `near`.
   */
  constructor(readonly module: Module, private readonly projection: ArrayLike<number>, private readonly position: Vec3,
              private readonly axes: [Vec3, Vec3, Vec3], private readonly near: number) {}

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
