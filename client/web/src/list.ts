// The page of a server: its reels and live streams.
import { element } from "./controls/dom";
import { bytesText, timeText } from "./controls/time_text";
import "./element";
import type { PointreelPlayer } from "./element";
import { refusal } from "./fetching";

interface Reel { name: string; url: string; manifest: string; frames: number; fps: number; duration_us: number; bytes: number; codec: string }
interface Stream { name: string; url: string; publishing: boolean; viewers: number }

export async function showList(root: HTMLElement, base: URL, token: string | null): Promise<void> {
  const headers = new Headers({ Accept: "application/json" });
  if (token) headers.set("Authorization", `Bearer ${token}`);
  const response = await fetch(base, { headers, cache: "no-cache" });
  if (!response.ok) throw new Error(refusal(response));
  const { packages = [], streams = [] } = await response.json() as { packages?: Reel[]; streams?: Stream[] };
  const hash = token ? `#token=${encodeURIComponent(token)}` : "";
  const cards = element("ul", { class: "cards" });
  for (const stream of streams) {
    const link = element("a", { href: new URL(`?live=${encodeURIComponent(stream.name)}${hash}`, base).href },
      element("span", { class: "picture live" }), element("strong", {}, stream.name),
      element("small", {}, stream.publishing ? `live, ${stream.viewers} watching` : "not live at the moment"));
    cards.append(element("li", {}, link));
  }
  for (const reel of packages) {
    const picture = element("span", { class: "picture" });
    const path = reel.url.replace(/\/(reel\.json)?$/, "").replace(/^\//, "");
    cards.append(element("li", {}, element("a", { href: new URL(path + hash, base).href }, picture,
      element("strong", {}, reel.name),
      element("small", {}, `${timeText(reel.duration_us)}, ${reel.frames} ${reel.frames === 1 ? "frame" : "frames"}, ${bytesText(reel.bytes)}`))));
    posters.push({ picture, src: new URL(reel.manifest.replace(/^\//, ""), base).href });
  }
  root.replaceChildren(element("main", { class: "list" }, element("h1", {}, "Pointreel"),
    cards.childElementCount > 0 ? cards : element("p", {}, "This server has no reels and no live streams.")));
  // One after another: each takes workers and a WebGL context.
  for (const poster of posters.splice(0)) await drawPoster(poster.picture, poster.src, token);
}

const posters: { picture: HTMLElement; src: string }[] = [];

async function drawPoster(picture: HTMLElement, src: string, token: string | null): Promise<void> {
  const player = element("pointreel-player", { src, class: "drawing", ...(token ? { token } : {}) }) as PointreelPlayer;
  picture.append(player);
  await new Promise<void>((resolve) => {
    const end = () => resolve();
    player.addEventListener("firstpicture", end, { once: true });
    player.addEventListener("error", end, { once: true });
    setTimeout(end, 10_000);
  });
  // A moment for the finer layers.
  await new Promise((resolve) => setTimeout(resolve, 300));
  if (player.player.pictures > 0) {
    const still = await player.player.still().catch(() => null);
    if (still) picture.append(element("img", { src: URL.createObjectURL(still), alt: "" }));
  }
  player.remove();
}
