// What is played, and where it stands, as people write it.
import { Vec3 } from "./module";

/** Addresses, separated by spaces. Those that are neither of live streams nor of a file are folders with a reel.json. */
export function sourcesOf(text: string): string[] {
  return text.split(/\s+/).filter((source) => source !== "")
    .map((s) => (/^wss?:/.test(s) || /\.json(\?|$)/.test(s) ? s : s.replace(/\/?(\?|$)/, "/reel.json$1")));
}

/** Part of an address, for people; as it is, if it is not UTF-8: names need not be. */
export function decoded(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

/** "x,y,z x,y,z"; what is no number counts as 0. */
export function placesOf(text: string): Vec3[] {
  return text.split(/\s+/).filter((place) => place !== "").map((place) => {
    const [x, y, z] = place.split(",").map((part) => Number(part) || 0);
    return [x ?? 0, y ?? 0, z ?? 0];
  });
}
