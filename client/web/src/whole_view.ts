// What must be ready so that a scene can be seen from a place in any direction, by several eyes.
import { Camera } from "./camera";
import { Box, Module, Vec3 } from "./module";

/** From inside a scene, or close to it, only what is within such an angle of its middle is made ready. */
const WIDEST = 2.6;
const LARGEST = 8192;  // pixels
const MOVED = 0.02;    // of the distance: how far an eye moves until other details are made ready

export interface WholeView {
  camera: Camera;
  /** Pixels of a square picture, each as large as the eyes' are. */
  size: number;
}

/** `pixelsAtDepth1`: of the eyes' pictures, along an edge of length 1 at depth 1. */
function wholeView(module: Module, box: Box, up: number, eye: Vec3, pixelsAtDepth1: number): WholeView {
  const camera = new Camera(module, up);
  camera.frameBounds(box, 1);
  const { state } = camera, front = new Camera(module, up).seenFrom([0, 0, 0], 1).axes;
  const middle = box.min.map((v, i) => (v + box.max[i]!) / 2);
  const radius = Math.hypot(...box.max.map((v, i) => (v - box.min[i]!) / 2));
  const [x, y, z] = front.map((axis) => axis.reduce((sum, v, i) => sum + v * (eye[i]! - middle[i]!), 0)) as Vec3;
  const distance = Math.max(Math.hypot(x, y, z), 1e-3 * radius);
  state.set(middle);
  state[3] = distance;
  state[4] = state[5] = 0;
  camera.orbit(Math.atan2(x, z), Math.asin(Math.min(1, Math.max(-1, y / distance))));
  state[6] = distance > radius ? Math.min(2 * Math.asin(radius / distance), WIDEST) : WIDEST;
  return { camera, size: Math.min(Math.ceil(2 * Math.tan(state[6]! / 2) * pixelsAtDepth1), LARGEST) };
}

/** The view of an eye that moves, which changes only where that makes a difference. */
export class FollowingView {
  seen: WholeView | null = null;
  private eye: Vec3 = [0, 0, 0];
  private pixels = 0;

  /** The arguments are those of wholeView. */
  follow(module: Module, box: Box, up: number, eye: Vec3, pixelsAtDepth1: number): WholeView {
    const moved = Math.hypot(...eye.map((v, i) => v - this.eye[i]!));
    if (this.seen && moved < MOVED * this.seen.camera.distance && pixelsAtDepth1 === this.pixels) return this.seen;
    this.eye = eye;
    this.pixels = pixelsAtDepth1;
    return (this.seen = wholeView(module, box, up, eye, pixelsAtDepth1));
  }
}
