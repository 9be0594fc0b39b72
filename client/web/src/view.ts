// What is drawn and from where: PrView and PrPrepare of wasm/module.h.
import { Camera } from "./camera";
import { COLORS, ColorSource, Mode, MODES, Vec3 } from "./module";

export interface Look {
  camera: Camera;
  /** Pixels of the picture. */
  width: number;
  height: number;
  mode: Mode;
  color: ColorSource;
  fillHoles: boolean;
  /** Divide surfels that look large: only where a picture is not urgent. */
  refine: boolean;
  /** Changes with each of the others. */
  number: number;
}

/** How much more than the picture is packed, so that the camera may move a little meanwhile. */
const WIDEN = 1.25;

/** `place` is added to the coordinates of the frame. */
export function viewOf(look: Look, place: Vec3 = [0, 0, 0]): Float64Array {
  const view = new Float64Array(20);
  view.set(look.camera.state);
  view.set([look.width, look.height, 1, WIDEN, MODES.indexOf(look.mode), COLORS.indexOf(look.color),
            Number(look.fillHoles), Number(look.refine), ...place], 9);
  return view;
}

export function prepareOptions(look: Look, level: number, index: number, timeUs: number,
                               cube: readonly number[], maxMemory: number): Float64Array {
  return Float64Array.of(MODES.indexOf(look.mode), level, -1, Number(look.color === "normals"),
                         maxMemory, index, timeUs, ...cube);
}
