// client/render/region.h, for several parts of a scene.
import { Module } from "../module";

/** Pixels from min (included) to max (excluded), from the lower left corner. */
export interface Rect {
  x0: number;
  y0: number;
  x1: number;
  y1: number;
}
export const EMPTY: Rect = { x0: 0, y0: 0, x1: 0, y1: 0 };
export const isNone = (r: Rect): boolean => r.x0 >= r.x1 || r.y0 >= r.y1;

export function around(a: Rect, b: Rect): Rect {
  if (isNone(a)) return b;
  if (isNone(b)) return a;
  return { x0: Math.min(a.x0, b.x0), y0: Math.min(a.y0, b.y0),
           x1: Math.max(a.x1, b.x1), y1: Math.max(a.y1, b.y1) };
}

/** What the module says of a part's bounds (PrBounds) in a picture. */
export class Place {
  constructor(private readonly module: Module, private readonly bounds: Float64Array,
              private readonly toClip: Float32Array, private readonly width: number,
              private readonly height: number) {}

  region(scale: number, pixels: number): Rect {
    const [bounds, toClip] = this.module.put(this.bounds, this.toClip);
    const r = this.module.ints(this.module.call("pr_region", bounds!, scale, toClip!, this.width,
                                                this.height, pixels), 4);
    return { x0: r[0]!, y0: r[1]!, x1: r[2]!, y1: r[3]! };
  }
  nearest(near: number): number {
    const [bounds, toClip] = this.module.put(this.bounds, this.toClip);
    return this.module.call("pr_nearest_depth", bounds!, toClip!, near);
  }
  radiusInPixels(): number {
    const [bounds, toClip] = this.module.put(this.bounds, this.toClip);
    return this.module.call("pr_radius_in_pixels", bounds!, toClip!, this.width, this.height);
  }
  get largestRadius(): number { return this.bounds[6]!; }
  get radii(): number { return this.bounds[7]!; }
  get count(): number { return this.bounds[8]!; }
}
