// The panels: help, drawing settings and statistics.
import { coloringOf, colorText, LEAST_ROUGHNESS } from "../colors";
import { COLORS, LIGHTS, MODES } from "../module";
import { Player, Settings } from "../player";
import { element } from "./dom";
import { BINDINGS, GESTURES, keyName } from "./keys";
import { bytesText, countText } from "./time_text";

function panel(title: string, close: () => void, ...children: Node[]): HTMLElement {
  const button = element("button", { type: "button", class: "close", "aria-label": `Close ${title.toLowerCase()}` }, "×");
  button.onclick = close;
  const made = element("section", { class: "panel", "aria-label": title },
                       element("h2", {}, title, button), ...children);
  made.hidden = true;
  return made;
}

export function helpPanel(close: () => void): HTMLElement {
  const list = element("dl");
  for (const { keys, help } of BINDINGS)
    list.append(element("dt", {}, ...keys.map((key) => element("kbd", {}, keyName(key)))), element("dd", {}, help));
  for (const [gesture, help] of GESTURES)
    list.append(element("dt", {}, gesture), element("dd", {}, help));
  return panel("Keys and gestures", close, list);
}

const COLOR_NAMES = ["Colours", "Normals", "Plain", "Curvature", "Accessibility", "Depth", "Contours"];

export class DrawingPanel {
  readonly root: HTMLElement;
  private readonly updates: (() => void)[] = [];

  constructor(private readonly player: Player, close: () => void) {
    this.root = panel("Drawing", close,
      this.choice("Mode", "mode", MODES, ["Surfels", "Voxels", "Points", "Strips"]),
      this.color(), this.range(), this.choice("Light", "light", LIGHTS, ["Flat", "Studio", "Environment"],
        (value, { environment }) => value !== "environment" || environment !== ""), this.roughness(),
      this.flag("Lighting", "lighting", ({ light }) => light === "flat"), this.flag("Fill holes", "fillHoles"),
      this.flag("Smooth outlines", "smoothOutlines"), this.flag("Floor grid", "floor"),
      this.flag("Adaptive points", "adaptivePoints"), this.pointSize(), this.background(), this.volume());
    this.update();
  }
  update(): void { for (const update of this.updates) update(); }

  /** The names of scalar fields follow those of what is known of everything. */
  private color(): Node {
    const list = element("select");
    let offered = "";
    list.onchange = () => this.player.set(coloringOf(list.value));
    this.updates.push(() => {
      const shown = colorText(this.player.settings), fields = this.player.scalars.map(({ name }) => name);
      const missing = [...COLORS, ...fields].includes(shown) ? [] : [shown], names = [...fields, ...missing];
      if (offered !== names.join("\n") || list.options.length === 0) {
        list.replaceChildren(...COLORS.map((name, i) => element("option", { value: name }, COLOR_NAMES[i]!)),
                             ...names.map((name) => element("option", { value: name }, name)));
        offered = names.join("\n");
      }
      list.value = shown;
    });
    return element("label", {}, list, "Colour");
  }
  /** The values at the ends of the ramp. */
  private range(): Node {
    const ends = ["Least", "Largest"].map((name) => element("input", { type: "number", step: "any", "aria-label": `${name} value` }));
    const [least, most] = ends as [HTMLInputElement, HTMLInputElement], row = element("label", {}, least, most, "Range");
    const source = () => this.player.scalars.find(({ name }) => name === this.player.settings.scalar?.field);
    const set = () => {
      const { scalar } = this.player.settings, known = source();
      if (!scalar) return;
      const [from, to] = [least.value === "" ? known?.least : Number(least.value), most.value === "" ? known?.most : Number(most.value)];
      const isAsked = least.value !== "" || most.value !== "";
      if (isAsked && !(from !== undefined && to !== undefined && from < to)) return;
      this.player.set({ scalar: { field: scalar.field, range: isAsked ? [from!, to!] : null } });
    };
    ends.forEach((end) => (end.onchange = set));
    this.updates.push(() => {
      const { color, scalar } = this.player.settings, known = source();
      row.hidden = color !== "colors" || !scalar;
      ends.forEach((end, i) => {
        end.placeholder = known ? String(i === 0 ? known.least : known.most) : "";
        // What somebody types is his.
        if ((end.getRootNode() as ShadowRoot).activeElement !== end) end.value = scalar?.range ? String(scalar.range[i]) : "";
      });
    });
    return row;
  }
  private roughness(): Node {
    const slider = element("input", { type: "range", min: String(LEAST_ROUGHNESS), max: "1", step: "0.01" });
    const label = element("label", {}, slider, "Roughness");
    slider.oninput = () => this.player.set({ roughness: Number(slider.value) });
    this.updates.push(() => {
      slider.value = String(this.player.settings.roughness);
      label.hidden = this.player.settings.light === "flat";
    });
    return label;
  }
  private choice<K extends "mode" | "light">(label: string, key: K, values: readonly Settings[K][], names: string[],
                                              isOffered: (value: Settings[K], settings: Settings) => boolean = () => true): Node {
    const group = element("div", { role: "radiogroup", "aria-label": label, class: "choice" });
    values.forEach((value, i) => {
      const button = element("button", { type: "button", role: "radio" }, names[i]!);
      button.onclick = () => this.player.set({ [key]: value });
      this.updates.push(() => {
        button.setAttribute("aria-checked", String(this.player.settings[key] === value));
        button.hidden = !isOffered(value, this.player.settings);
      });
      group.append(button);
    });
    return group;
  }
  private flag(label: string, key: "lighting" | "fillHoles" | "smoothOutlines" | "floor" | "adaptivePoints",
               counts: (settings: Settings) => boolean = () => true): Node {
    const box = element("input", { type: "checkbox" });
    box.onchange = () => this.player.set({ [key]: box.checked });
    const made = element("label", {}, box, label);
    this.updates.push(() => {
      box.checked = this.player.settings[key];
      made.hidden = !counts(this.player.settings);
    });
    return made;
  }
  private pointSize(): Node {
    const slider = element("input", { type: "range", min: "1", max: "16", step: "0.5" });
    slider.oninput = () => this.player.set({ pointSize: Number(slider.value) });
    this.updates.push(() => (slider.value = String(this.player.settings.pointSize)));
    return element("label", {}, slider, "Point size");
  }
  private volume(): Node {
    const slider = element("input", { type: "range", min: "0", max: "1", step: "0.01" });
    slider.oninput = () => this.player.setVolume(Number(slider.value), false);
    const label = element("label", {}, slider, "Volume");
    this.updates.push(() => {
      slider.value = String(this.player.muted ? 0 : this.player.volume);
      label.hidden = !this.player.sound;
    });
    return label;
  }
  private background(): Node {
    const input = element("input", { type: "color" });
    input.oninput = () => this.player.set({ background: [1, 3, 5].map((i) => parseInt(input.value.slice(i, i + 2), 16) / 255) as Settings["background"] });
    this.updates.push(() => {
      input.value = "#" + this.player.settings.background.map((c) => Math.round(255 * c).toString(16).padStart(2, "0")).join("");
    });
    return element("label", {}, input, "Background");
  }
}

const LIMITS = ["", "as asked", "more would not be seen", "the link carries no more", "this machine makes no more"];

export class StatisticsPanel {
  readonly root: HTMLElement;
  private readonly list = element("dl");
  private last = { time: 0, shown: 0 };
  private rate = 0;

  constructor(private readonly player: Player, close: () => void) { this.root = panel("Statistics", close, this.list); }

  update(): void {
    const now = performance.now();
    if (this.root.hidden || now - this.last.time < 500) return;
    const { player } = this, reel = player.reel, made = reel?.shown ?? player.live[0]?.shown;
    const shown = reel?.counts.shown ?? player.live.reduce((sum, live) => sum + live.frames, 0);
    this.rate = (1000 * (shown - this.last.shown)) / (now - this.last.time);
    this.last = { time: now, shown };
    const lines: [string, string][] = [["Shown", `${this.rate.toFixed(1)} frames/s`],
                                       ["Drawn", `${countText(player.drawn)} elements`]];
    if (made) {
      lines.push(["Frame", `${countText(made.facts.points)} points, depth ${made.facts.depth}`]);
      lines.push(["Made in", `${made.times.prepareMs.toFixed(1)} ms, cut ${made.times.packMs.toFixed(1)} ms`]);
    }
    if (reel) {
      lines.push(["Layers", `${reel.wanted.end} of ${reel.reel.layers}${reel.limit ? `: ${LIMITS[reel.limit]}` : ""}`]);
      lines.push(["Dropped", `${reel.counts.dropped}, stalls ${reel.counts.stalls}, errors ${reel.counts.errors}`]);
      lines.push(["Fetched", `${bytesText(player.traffic.bytes)} in ${player.traffic.requests} requests`]);
      const rate = reel.control.bytesPerSecond;
      if (rate > 0) lines.push(["Link", `${((8 * rate) / 1e6).toFixed(1)} Mbit/s`]);
      lines.push(["Buffers", `${bytesText(player.memory)} ready, ${bytesText(reel.store.heldBytes)} coded`]);
    }
    if (player.isLive) {
      const { delayMs, sound } = player.live[0]!, text = (ms: number) => `${Math.max(0, ms).toFixed(0)} ms`;
      lines.push(["Delay", text(delayMs) + (Number.isNaN(sound.delayMs) ? "" : `, sound ${text(sound.delayMs)}`)]);
    }
    lines.push(["Drawing", `${player.drawMs.toFixed(1)} ms, ${player.driver}`]);
    this.list.replaceChildren(...lines.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
  }
}
