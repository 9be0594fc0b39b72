// The part of an address behind "#": time, view, mode, colours and light of what is shown.
import { Camera, directionOf } from "./camera";
import { colorText, rangeText } from "./colors";
import { Mode, MODES } from "./module";
import { DEFAULTS, Settings } from "./player";

/** Attributes of the element that are named as options of the desktop player. */
export const DRAWING = ["color", "color-range", "light", "environment", "roughness"] as const;

export interface Shown {
  seconds?: number;
  mode?: Mode;
  /** Those of DRAWING that the address has. */
  drawing: Map<string, string>;
  view?: (camera: Camera) => void;
  /** A direction to look from, as the element's attribute `view` has it. */
  direction?: string;
}

const VIEW_NUMBERS = 7;  // target, distance, yaw, pitch, up

export function readFragment(hash: string): Shown {
  const fields = new URLSearchParams(hash.replace(/^#/, "")), shown: Shown = { drawing: new Map() };
  for (const name of DRAWING) if (fields.has(name)) shown.drawing.set(name, fields.get(name)!);
  const t = Number(fields.get("t") ?? NaN), mode = fields.get("mode");
  if (t >= 0 && t < 1e9) shown.seconds = t;
  if (mode && (MODES as readonly string[]).includes(mode)) shown.mode = mode as Mode;
  // The window's option is called --camera.
  const named = fields.get("view") ?? fields.get("camera") ?? "", view = named.split(",").map(Number);
  if (directionOf(named)) shown.direction = named;
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

export function writeFragment(seconds: number | null, settings: Settings, camera: Camera | null): string {
  const fields: string[] = [], { mode, light, environment, roughness } = settings, color = colorText(settings), range = rangeText(settings);
  if (seconds !== null) fields.push(`t=${seconds.toFixed(3)}`);
  if (mode !== DEFAULTS.mode) fields.push(`mode=${mode}`);
  if (color !== DEFAULTS.color) fields.push(`color=${encodeURIComponent(color)}`);
  if (range && color !== DEFAULTS.color) fields.push(`color-range=${range}`);
  if (light !== DEFAULTS.light) fields.push(`light=${light}`);
  if (environment) fields.push(`environment=${encodeURIComponent(environment)}`);
  if (roughness !== DEFAULTS.roughness) fields.push(`roughness=${roughness}`);
  if (camera) {
    const s = camera.state, short = (n: number) => Number(n.toPrecision(7));
    fields.push(`view=${[s[0]!, s[1]!, s[2]!, s[3]!, s[4]!, s[5]!, s[8]!].map(short).join(",")}`);
  }
  return `#${fields.join("&")}`;
}
