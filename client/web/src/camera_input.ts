// The camera by mouse and touch. Keys are in controls/keys.ts.
import { Player } from "./player";

interface Finger {
  x: number;
  y: number;
}

/** `scrub`: a drag with shift goes to a time, given as a share of the width; null ends it. */
export function followPointers(canvas: HTMLCanvasElement, player: Player, scrub: (share: number | null) => void): void {
  const fingers = new Map<number, Finger>();
  let pans = false, scrubs = false, lastTap = 0, lastAt: Finger = { x: 0, y: 0 }, travelled = 0;
  const height = () => Math.max(1, canvas.clientHeight);
  const share = (x: number) => {
    const box = canvas.getBoundingClientRect();
    return Math.min(1, Math.max(0, (x - box.left) / box.width));
  };
  const center = (at: Finger) => {
    const box = canvas.getBoundingClientRect();
    const point = player.pointAt((at.x - box.left) / box.width, (at.y - box.top) / box.height);
    if (point) player.move((camera) => camera.centerOn(point));
  };
  const zoomAt = (factor: number, at: Finger) => {
    const box = canvas.getBoundingClientRect();
    const x = (2 * (at.x - box.left)) / box.width - 1, y = 1 - (2 * (at.y - box.top)) / box.height;
    player.move((camera) => camera.zoomAt(factor, x, y, box.width / box.height));
  };

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    pans = event.button === 2 || event.button === 1;
    scrubs = event.shiftKey && fingers.size === 1;
    travelled = 0;
    if (scrubs) scrub(share(event.clientX));
  });
  canvas.addEventListener("pointermove", (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) return;
    const dx = event.clientX - finger.x, dy = event.clientY - finger.y;
    travelled += Math.hypot(dx, dy);
    if (scrubs) return scrub(share(event.clientX));
    if (fingers.size === 1) {
      finger.x = event.clientX;
      finger.y = event.clientY;
      if (pans) player.move((camera) => camera.pan(-dx / height(), dy / height()));
      // A drag across the height of the picture is half a turn.
      else player.move((camera) => camera.orbit((-dx / height()) * Math.PI, (dy / height()) * Math.PI));
      return;
    }
    const [a, b] = [...fingers.values()] as [Finger, Finger];
    const middle = () => ({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 });
    const before = middle(), apart = Math.max(1, Math.hypot(a.x - b.x, a.y - b.y));
    finger.x = event.clientX;
    finger.y = event.clientY;
    const after = middle(), now = Math.max(1, Math.hypot(a.x - b.x, a.y - b.y));
    player.move((camera) => camera.pan(-(after.x - before.x) / height(), (after.y - before.y) / height()));
    zoomAt(apart / now, after);
  });
  const up = (event: PointerEvent) => {
    const finger = fingers.get(event.pointerId);
    if (!fingers.delete(event.pointerId) || !finger) return;
    if (scrubs) scrub(null);
    scrubs = false;
    if (event.type !== "pointerup" || travelled > 8 || fingers.size > 0) return;
    const isDouble = event.timeStamp - lastTap < 350 && Math.hypot(finger.x - lastAt.x, finger.y - lastAt.y) < 24;
    lastTap = isDouble ? 0 : event.timeStamp;
    lastAt = finger;
    if (isDouble) center(finger);
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 0 ? event.deltaY / 100 : event.deltaMode === 1 ? event.deltaY / 3 : event.deltaY;
    zoomAt(0.9 ** Math.max(-3, Math.min(3, -lines)), { x: event.clientX, y: event.clientY });
  }, { passive: false });
}
