// What is drawn and from where: PrView and PrPrepare of wasm/module.h.
import { Camera } from "./camera";
import { ScalarChoice, ScalarRange, showsNormals } from "./colors";
import { COLORS, ColorSource, Light, Mode, MODES, Vec3 } from "./module";

export interface Look {
  camera: Camera;
  /** Pixels of the picture. */
  width: number;
  height: number;
  mode: Mode;
  color: ColorSource;
  light: Light;
  /** Null: none is shown. */
  scalar: ScalarChoice | null;
  fillHoles: boolean;
  /** Divide surfels that look large: only where a picture is not urgent. */
  refine: boolean;
  /** The least size of what is drawn, in pixels. */
  pixelSize: number;
  /** Changes with each of the others. */
  number: number;
}

/** How much more than the picture is packed, so that the camera may move a little meanwhile. */
const WIDEN = 1.25;

/** `place` is added to the coordinates of the frame. */
export function viewOf(look: Look, place: Vec3 = [0, 0, 0]): Float64Array {
  const view = new Float64Array(20);
  view.set(look.camera.state);
  view.set([look.width, look.height, look.pixelSize, WIDEN, MODES.indexOf(look.mode), COLORS.indexOf(look.color),
            Number(look.fillHoles), Number(look.refine), ...place], 9);
  return view;
}

/** What a frame must be made again for. */
export interface Kind {
  mode: Mode;
  normals: boolean;
  scalar: ScalarChoice | null;
}
export const kindOf = ({ mode, color, light, scalar }: Look): Kind => ({ mode, normals: showsNormals(color, light), scalar });
export const fits = (made: Kind, look: Look): boolean => {
  const wanted = kindOf(look);
  return made.mode === wanted.mode && (made.normals || !wanted.normals) && isSame(made.scalar, wanted.scalar);
};
const isSame = (a: ScalarChoice | null, b: ScalarChoice | null): boolean =>
  a === b || (a !== null && b !== null && a.field === b.field && String(a.range) === String(b.range));

/** What the module is told of how to make a frame. */
export interface Preparation {
  /** PrPrepare. */
  options: Float64Array;
  field: string;
  /** PrScalar. */
  scalar: Float64Array;
}

/** `of`: what the source says of all its frames. */
export function preparation(look: Look, level: number, index: number, timeUs: number, cube: readonly number[],
                            maxMemory: number, of: { scalars: readonly ScalarRange[], normalsEstimated: boolean },
                            ): Preparation {
  const { mode, normals, scalar } = kindOf(look), source = of.scalars.find(({ name }) => name === scalar?.field);
  return {
    options: Float64Array.of(MODES.indexOf(mode), level, -1, Number(normals), maxMemory, index, timeUs, ...cube,
                             Number(of.normalsEstimated)),
    field: scalar?.field ?? "",
    scalar: Float64Array.of(...(scalar?.range ?? [NaN, NaN]), Number(source !== undefined),
                            source?.least ?? 0, source?.most ?? 0, Number(source?.labels ?? false)),
  };
}
