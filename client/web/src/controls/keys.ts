// The keys of the desktop player (client/ui/bindings.cpp) that a page has a use for.
import { MODES } from "../module";
import { NamedView } from "../camera";
import { Player } from "../player";
import { timeText } from "./time_text";

export interface Interface {
  say(text: string): void;
  toggle(panel: "help" | "drawing" | "statistics"): void;
  fullscreen(): void;
  savePicture(): void;
  toggleLoop(): void;
  /** Closes what is open; false if nothing was. */
  leave(): boolean;
}

type Act = (player: Player, ui: Interface) => void;
interface Binding {
  keys: string[];
  help: string;
  acts: Act[];
}

const SECOND = 1e6;
const tellTime: Act = (player, ui) => {
  const reel = player.reel;
  if (!reel) return ui.say(player.isLive ? "a live stream has no other time to go to" : "");
  const { positionUs, frame } = reel.clock.read();
  ui.say(`${timeText(positionUs)} / ${timeText(reel.reel.durationUs)}   frame ${reel.reel.shownIndex(frame) + 1} of ${reel.reel.shownFrames}`);
};
const by = (seconds: number): Act => (player, ui) => {
  player.seekBy(seconds * SECOND);
  tellTime(player, ui);
};
const speed = (change: (now: number) => number): Act => (player, ui) => {
  if (!player.reel) return;
  player.setSpeed(change(player.reel.clock.state().speed));
  ui.say(`speed ${player.reel.clock.state().speed.toFixed(2)}x`);
};
const step = (frames: number): Act => (player, ui) => {
  player.step(frames);
  tellTime(player, ui);
};
const view = (name: NamedView): Act => (player, ui) => {
  player.move((camera) => camera.lookFrom(name));
  ui.say(String(name));
};
const loopMark = new WeakMap<Player, number>();
/** Sets A the first time, then B, then clears both. */
const markLoop: Act = (player, ui) => {
  const reel = player.reel;
  if (!reel) return;
  const a = loopMark.get(player), now = reel.clock.read().positionUs;
  if (reel.clock.state().range) {
    player.setRange(null);
    ui.say("A-B loop cleared");
  } else if (a === undefined) {
    loopMark.set(player, now);
    ui.say(`A at ${timeText(now)}`);
  } else {
    loopMark.delete(player);
    player.setRange({ a: Math.min(a, now), b: Math.max(a, now) });
    ui.say(`loop from ${timeText(Math.min(a, now))} to ${timeText(Math.max(a, now))}`);
  }
};
export const markedA = (player: Player): number | undefined => loopMark.get(player);

export const togglePlay: Act = (player) => (player.playing ? player.pause() : player.play());
const louder = (by: number): Act => (player, ui) => {
  if (!player.sound) return;
  // Whoever asks for louder sound wants to hear it.
  player.setVolume(player.volume + by, player.muted && by < 0);
  ui.say(`volume ${Math.round(100 * player.volume)} %`);
};
export const toggleMute: Act = (player, ui) => {
  const { sound } = player;
  if (!sound) return;
  player.setVolume(player.volume, !player.muted);
  ui.say(sound.problem ?? (player.muted ? "sound off" : "sound on"));
};
const tenth = (sign: number): Act => (player, ui) =>
  by(sign * (player.reel?.reel.durationUs ?? 0) / 10 / SECOND)(player, ui);

export const BINDINGS: readonly Binding[] = [
  { keys: [" ", "p"], help: "play or pause", acts: [togglePlay, togglePlay] },
  { keys: ["ArrowLeft", "ArrowRight"], help: "go back or forward 5 seconds", acts: [by(-5), by(5)] },
  { keys: ["Shift+ArrowLeft", "Shift+ArrowRight"], help: "go back or forward 1 second", acts: [by(-1), by(1)] },
  { keys: ["ArrowDown", "ArrowUp"], help: "go back or forward 1 minute", acts: [by(-60), by(60)] },
  { keys: ["PageDown", "PageUp"], help: "go back or forward a tenth of the length", acts: [tenth(-1), tenth(1)] },
  { keys: ["Home"], help: "go to the beginning", acts: [(player) => player.seek(0)] },
  { keys: ["End"], help: "go to the last frame and pause", acts: [(player) => {
    player.pause();
    if (player.reel) player.seek(player.reel.reel.timesUs[player.reel.reel.frames - 1]!);
  }] },
  { keys: [",", "."], help: "pause and step one frame back or forward", acts: [step(-1), step(1)] },
  { keys: ["[", "]"], help: "play 10 % slower or faster", acts: [speed((s) => s / 1.1), speed((s) => s * 1.1)] },
  { keys: ["{", "}"], help: "play at half or twice the speed", acts: [speed((s) => s / 2), speed((s) => s * 2)] },
  { keys: ["Backspace"], help: "play forward at normal speed", acts: [speed(() => 1)] },
  { keys: ["r"], help: "reverse the direction", acts: [speed((s) => -s)] },
  { keys: ["l"], help: "A-B loop: set A, then B, then clear", acts: [markLoop] },
  { keys: ["L"], help: "loop at the end, or stop there", acts: [(player, ui) => {
    ui.toggleLoop();
    ui.say(player.loop ? "loop" : "no loop");
  }] },
  { keys: ["o"], help: "show the time and the frame number", acts: [tellTime] },
  { keys: ["/", "*"], help: "quieter or louder", acts: [louder(-0.05), louder(0.05)] },
  { keys: ["M"], help: "sound off, or on again", acts: [toggleMute] },
  { keys: ["m"], help: "next mode: surfels, voxels, points, strips", acts: [(player, ui) => {
    player.set({ mode: MODES[(MODES.indexOf(player.settings.mode) + 1) % MODES.length]! });
    ui.say(`${player.settings.mode}s`);
  }] },
  { keys: ["g"], help: "show or hide a grid on the floor", acts: [(player) => player.set({ floor: !player.settings.floor })] },
  { keys: ["0"], help: "return to the first view", acts: [(player) => player.lookHome()] },
  { keys: ["1", "2", "3", "4", "5", "6"], help: "look from the front, back, left, right, top, bottom",
    acts: [view("front"), view("back"), view("left"), view("right"), view("top"), view("bottom")] },
  { keys: ["u"], help: "flip upside down", acts: [(player) => player.move((camera) => camera.turnOver())] },
  { keys: ["w", "a", "x", "e"], help: "turn the scene up, left, down, right", acts: [
    (player) => player.move((c) => c.orbit(0, 0.1)), (player) => player.move((c) => c.orbit(-0.1, 0)),
    (player) => player.move((c) => c.orbit(0, -0.1)), (player) => player.move((c) => c.orbit(0.1, 0))] },
  { keys: ["+", "-"], help: "zoom in or out", acts: [
    (player) => player.move((c) => c.zoom(0.9)), (player) => player.move((c) => c.zoom(1 / 0.9))] },
  { keys: ["d"], help: "show or hide the drawing settings", acts: [(_, ui) => ui.toggle("drawing")] },
  { keys: ["i"], help: "show or hide the statistics", acts: [(_, ui) => ui.toggle("statistics")] },
  { keys: ["f"], help: "enter or leave full screen", acts: [(_, ui) => ui.fullscreen()] },
  { keys: ["s"], help: "save a picture", acts: [(_, ui) => ui.savePicture()] },
  { keys: ["?", "F1"], help: "show or hide this help", acts: [(_, ui) => ui.toggle("help"), (_, ui) => ui.toggle("help")] },
];
export const GESTURES: readonly [string, string][] = [
  ["drag, one finger", "turn the scene"],
  ["right drag, two fingers", "move the scene"],
  ["wheel, pinch", "zoom in or out"],
  ["double click", "turn the scene about this point"],
  ["shift + drag", "go to any time, as on the timeline"],
];

/** True if the key was used. */
export function press(event: KeyboardEvent, player: Player, ui: Interface): boolean {
  if (event.ctrlKey || event.altKey || event.metaKey) return false;
  if (event.key === "Escape") return ui.leave();
  const isArrow = event.key.startsWith("Arrow");
  const name = event.shiftKey && isArrow ? `Shift+${event.key}` : event.key;
  for (const { keys, acts } of BINDINGS) {
    const at = keys.indexOf(name);
    if (at < 0) continue;
    acts[at]!(player, ui);
    return true;
  }
  return false;
}

const NAMES: Record<string, string> = { " ": "space", ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓" };
export const keyName = (key: string): string =>
  key.split("+").map((part) => NAMES[part] ?? part).join(" + ") || "+";
