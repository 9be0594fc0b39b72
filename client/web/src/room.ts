// Places a scene in a room: metres, y up, the floor at y = 0.
import { Camera } from "./camera";
import { Box, Module, Vec3 } from "./module";
import { PosedEye } from "./posed_eye";

const METRES_TALL = [0.5, 3] as const;  // heights that are taken for metres
const HEIGHT = 1.7;    // metres, of what has another height

/** Where a scene stands: on the floor, around x = 0, with its front to +z. */
export class Room {
  /** Metres for a unit of the scene. */
  readonly scale: number;
  /** Width, height and depth of the scene in metres. */
  readonly size: Vec3;
  private readonly axes: [Vec3, Vec3, Vec3];
  private readonly foot: Vec3;
  private readonly back: number;

  /** `away`: metres from z = 0 to the front of the scene; null if its middle is at z = 0. */
  constructor(private readonly module: Module, box: Box, private readonly up: number, away: number | null) {
    const axis = Math.abs(up) - 1, height = box.max[axis]! - box.min[axis]!;
    const isMetres = height >= METRES_TALL[0] && height <= METRES_TALL[1];
    this.scale = isMetres || !(height > 0) ? 1 : HEIGHT / height;
    this.axes = new Camera(module, up).seenFrom([0, 0, 0], 1).axes;
    this.foot = box.min.map((v, i) => (v + box.max[i]!) / 2) as Vec3;
    this.foot[axis] = up > 0 ? box.min[axis]! : box.max[axis]!;
    this.size = this.axes.map((direction) => this.scale *
      direction.reduce((sum, v, i) => sum + Math.abs(v) * (box.max[i]! - box.min[i]!), 0)) as Vec3;
    this.back = away === null ? 0 : away + 0.5 * this.size[2];
  }

  direction(x: number, y: number, z: number): Vec3 {
    return [0, 1, 2].map((i) => x * this.axes[0][i]! + y * this.axes[1][i]! + z * this.axes[2][i]!) as Vec3;
  }
  /** Of the scene, for one of the room. */
  point(x: number, y: number, z: number): Vec3 {
    const from = this.direction(x, y, z + this.back);
    return this.foot.map((v, i) => v + from[i]! / this.scale) as Vec3;
  }
  /**
   * `pose`: the matrix from the eye to the room, in columns, whose axes have length 1. `projection`: as of
   * PosedEye. `near` is in metres.
   */
  eye(pose: ArrayLike<number>, projection: ArrayLike<number>, near: number): PosedEye {
    const axis = (i: number) => this.direction(pose[i]!, pose[i + 1]!, pose[i + 2]!);
    return new PosedEye(this.module, projection, this.point(pose[12]!, pose[13]!, pose[14]!), [axis(0), axis(4), axis(8)],
                        near / this.scale, this.up);
  }
}
