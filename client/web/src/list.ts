// The page of a server: its reels and live streams.
import { element } from "./controls/dom";
import { bytesText, timeText } from "./controls/time_text";
import "./element";
import type { PointreelPlayer } from "./element";
import { checkToken, refusal } from "./fetching";

interface Reel { name: string; url: string; manifest: string; frames: number; fps: number; duration_us: number; bytes: number; codec: string; changed_us?: number; captured_us?: number }
interface Stream { name: string; url: string; publishing: boolean; viewers: number }

/** A path of the server's list, which may begin with "/" although the server is below a folder of another one. */
function within(base: URL, path: string): URL {
  const url = new URL(path.replace(/^\/+/, ""), base);
  // The token goes there.
  if (url.origin !== base.origin) throw new Error(`it names an address elsewhere, ${url.origin}`);
  return url;
}

/** The day, such as 2026-01-31, by this machine's clock. */
function dayText(us: number): string {
  const date = new Date(us / 1000), two = (n: number) => String(n).padStart(2, "0");
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())}`;
}

/** A field that leaves the cards that have all words of it, in their names, dates or other facts. */
function search(cards: HTMLElement, none: HTMLElement): HTMLElement {
  const field = element("input", { type: "search", placeholder: "Name or date", "aria-label": "Search by name or date" });
  field.addEventListener("input", () => {
    const words = field.value.toLowerCase().split(/\s+/);
    let shown = 0;
    for (const card of cards.children as HTMLCollectionOf<HTMLElement>) {
      const text = card.textContent!.toLowerCase();
      card.hidden = !words.every((word) => text.includes(word));
      if (!card.hidden) ++shown;
    }
    none.hidden = shown > 0;
  });
  return field;
}

/** Of entries that cannot be shown, the first. */
const MOST_FAULTS = 5;

interface Listed { packages?: Reel[]; streams?: Stream[] }

/** What the server lists; or, if it serves files and nothing else, the file that `pointreel-server page` has written. */
async function fetchList(base: URL, token: string | null): Promise<{ list: Listed; fromFile: boolean }> {
  checkToken(token);
  const headers = new Headers({ Accept: "application/json" });
  if (token) headers.set("Authorization", `Bearer ${token}`);
  const response = await fetch(base, { headers, cache: "no-cache" });
  const isList = (r: Response) => r.ok && (r.headers.get("Content-Type") ?? "").startsWith("application/json");
  if (isList(response)) return { list: await response.json(), fromFile: false };
  const file = await fetch(new URL("reels.json", base), { headers, cache: "no-cache" });
  if (isList(file)) return { list: await file.json(), fromFile: true };
  throw new Error(response.ok ? "there is no reels.json; pointreel-server page writes it" : refusal(response));
}

export async function showList(root: HTMLElement, base: URL, token: string | null): Promise<void> {
  const { list: { packages = [], streams = [] }, fromFile } = await fetchList(base, token);
  const hash = token ? `#token=${encodeURIComponent(token)}` : "";
  const cards = element("ul", { class: "cards" }), posters = new Posters(token);
  const add = (link: URL, name: string, live: boolean, ...facts: (string | Node)[]): HTMLElement => {
    const picture = element("span", { class: live ? "picture live" : "picture" });
    cards.append(element("li", {}, element("a", { href: link.href + hash }, picture, element("strong", {}, name),
                                           element("small", {}, ...facts))));
    return picture;
  };
  for (const { name, publishing, viewers } of streams.filter((stream) => typeof stream?.name === "string")) {
    const picture = add(new URL(`?live=${encodeURIComponent(name)}`, base), name, publishing,
                        publishing ? `live, ${viewers} watching` : "not live at the moment");
    const stream = new URL(`live/${encodeURIComponent(name)}`, base);
    stream.protocol = base.protocol.replace("http", "ws");
    if (publishing) posters.add(picture, stream.href);
  }
  const addReel = ({ name, url, manifest, duration_us, frames, bytes, changed_us, captured_us = changed_us }: Reel): void => {
    const poster = within(base, manifest), link = within(base, url.replace(/\/(reel\.json)?$/, ""));
    const played = new URL(`index.html?reel=${encodeURIComponent(`${link.pathname.slice(base.pathname.length)}/reel.json`)}`, base);
    const day = captured_us === undefined ? [] : [", ", element("time", {}, dayText(captured_us))];
    const picture = add(fromFile ? played : link, name, false,
                        `${timeText(duration_us)}, ${frames} ${frames === 1 ? "frame" : "frames"}, ${bytesText(bytes)}`, ...day);
    posters.add(picture, poster.href);
  };
  const faults: string[] = [];
  for (const reel of packages) {
    try {
      addReel(reel);
    } catch (error) {
      const why = error instanceof TypeError ? "its entry makes no sense" : (error as Error).message;
      faults.push(`${reel?.name ?? "A reel without a name"} is left out: ${why}`);
    }
  }
  const none = element("p", { hidden: "" }, "None of the reels and live streams has these words.");
  root.replaceChildren(element("main", { class: "list" }, element("h1", {}, "Pointreel"),
    ...(cards.childElementCount > 0 ? [search(cards, none), none, cards]
                                    : [element("p", {}, "This server has no reels and no live streams.")]),
    ...faults.slice(0, MOST_FAULTS).map((fault) => element("p", { class: "fault" }, fault))));
}

/**
 * Draws pictures of what is on the screen or close to it, one after another, because each takes workers and a
 * WebGL context while it is drawn.
 */
class Posters {
  private readonly sources = new Map<Element, string>();
  private readonly waiting = new Set<Element>();
  private isDrawing = false;
  private readonly observer = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) this.waiting.add(target);
      else this.waiting.delete(target);
    }
    this.draw();
  }, { rootMargin: "25%" });

  constructor(private readonly token: string | null) {}

  add(picture: Element, src: string): void {
    this.sources.set(picture, src);
    this.observer.observe(picture);
  }

  private async draw(): Promise<void> {
    if (this.isDrawing) return;
    this.isDrawing = true;
    for (let picture; (picture = [...this.waiting][0]);) {
      this.waiting.delete(picture);
      this.observer.unobserve(picture);
      await drawPoster(picture, this.sources.get(picture)!, this.token);
    }
    this.isDrawing = false;
  }
}

async function drawPoster(picture: Element, src: string, token: string | null): Promise<void> {
  const player = element("pointreel-player", { src, class: "drawing", muted: "", ...(token ? { token } : {}) }) as PointreelPlayer;
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
    if (still) {
      const url = URL.createObjectURL(still), image = element("img", { src: url, alt: "" });
      image.onload = () => URL.revokeObjectURL(url);
      picture.append(image);
    }
  }
  player.remove();
}
