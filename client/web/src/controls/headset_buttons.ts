// Buttons for headsets, where the browser says that there is one.
import { Player } from "../player";
import { element } from "./dom";

const MODES = [["immersive-vr", "VR", "Enter VR"], ["immersive-ar", "AR", "Enter AR"]] as const;

/** `say`: tells people, in one line, why a headset cannot be used. */
export function headsetButtons(player: Player, say: (text: string) => void): HTMLElement[] {
  const buttons = MODES.map(([mode, text, label]) => {
    const button = element("button", { type: "button", title: label, "aria-label": label }, text);
    button.hidden = true;
    button.onclick = () => {
      player.enter(mode).catch((error: Error) => say(`The headset cannot show this: ${error.message}`));
    };
    return button;
  });
  const ask = () => MODES.forEach(async ([mode], i) => {
    const isThere = await navigator.xr?.isSessionSupported(mode).catch(() => false);
    buttons[i]!.hidden = !isThere;
  });
  navigator.xr?.addEventListener("devicechange", ask);
  ask();
  return buttons;
}
