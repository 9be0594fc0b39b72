// The part of an address behind "#": time, view and mode of what is shown.
import { Camera } from "./camera";
import { Mode, MODES } from "./module";

export interface Shown {
  seconds?: number;
  mode?: Mode;
  view?: (camera: Camera) => void;
}

const VIEW_NUMBERS = 7;  // target, distance, yaw, pitch, up

export function readFragment(hash: string): Shown {
  const fields = new URLSearchParams(hash.replace(/^#/, "")), shown: Shown = {};
  const t = Number(fields.get("t") ?? NaN), mode = fields.get("mode");
  if (t >= 0 && t < 1e9) shown.seconds = t;
  if (mode && (MODES as readonly string[]).includes(mode)) shown.mode = mode as Mode;
  const view = fields.get("view")?.split(",").map(Number) ?? [];
  const isView = view.length === VIEW_NUMBERS && view.every(Number.isFinite) && view[3]! > 0 &&
    [1, 2, 3].includes(Math.abs(view[6]!));
  if (isView) {
    shown.view = (camera) => {
      camera.state.set(view.slice(0, 4));
      camera.state[8] = view[6]!;
      camera.state[4] = camera.state[5] = 0;
      camera.orbit(view[4]!, view[5]!);
      camera.zoom(1);  // within its bounds
    };
  }
  return shown;
}

export function writeFragment(seconds: number | null, mode: Mode, camera: Camera | null): string {
  const fields: string[] = [];
  if (seconds !== null) fields.push(`t=${seconds.toFixed(3)}`);
  if (mode !== "surfel") fields.push(`mode=${mode}`);
  if (camera) {
    const s = camera.state, short = (n: number) => Number(n.toPrecision(7));
    fields.push(`view=${[s[0]!, s[1]!, s[2]!, s[3]!, s[4]!, s[5]!, s[8]!].map(short).join(",")}`);
  }
  return `#${fields.join("&")}`;
}
