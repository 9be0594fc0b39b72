// The page: the list of a server at BASE/, a reel at BASE/REEL, live streams at BASE/?live=a,b.
import { element } from "./controls/dom";
import { PointreelPlayer } from "./element";
import { WANTS_TOKEN } from "./fetching";
import { DRAWING, readFragment, Shown, writeFragment } from "./fragment";
import { showList } from "./list";
import { decoded } from "./sources";

const root = document.getElementById("page")!;
const query = new URLSearchParams(location.search);

// Everything lies relative to this file, which is BASE/page/HASH/page.js. At BASE/live/STREAM the
// page's files are found below BASE/live, too.
const base = new URL(new URL("../../", import.meta.url).pathname.replace(/live\/$/, ""), location.href);
// A token in the fragment never reaches the server's log.
const tokenOf = () => new URLSearchParams(location.hash.slice(1)).get("token")?.trim() ?? null;
const token = tokenOf();

/** The addresses to play, or null for the list. */
function sources(): string | null {
  const live = (name: string) => {
    const url = new URL(`live/${encodeURIComponent(name)}`, base);
    url.protocol = base.protocol.replace("http", "ws");
    return url.href;
  };
  const names = (query.get("live") ?? "").split(",").map((name) => name.trim()).filter((name) => name !== "");
  if (names.length > 0) return names.map((name) => (/^wss?:/.test(name) ? name : live(name))).join(" ");
  const reel = query.get("reel")?.trim();
  if (reel) return reel.replace(/\s/g, encodeURIComponent);  // spaces are between addresses
  const path = location.pathname.slice(base.pathname.length).replace(/\/?(index\.html)?$/, "");
  if (path.startsWith("live/")) return live(decoded(path.slice(5)));
  return path === "" ? null : new URL(path, base).href;
}

/** Draws as the address says, and returns what else it says. */
function draw(player: PointreelPlayer): Shown {
  const shown = readFragment(location.hash);
  for (const [name, value] of [["mode", shown.mode], ["view", shown.direction], ...DRAWING.map((each) => [each, shown.drawing.get(each)])] as const) {
    if (value !== undefined) player.setAttribute(name!, value);
    else player.removeAttribute(name!);
  }
  player.applySettings();  // the panel may have changed what no attribute says
  return shown;
}

/** A link to the list, which is seen while the pointer moves, or once a key has led to it. */
function addWayBack(): void {
  const link = element("a", { class: "way-back", href: base.href + (token ? `#token=${encodeURIComponent(token)}` : "") }, "All reels");
  root.append(link);
  let timer = 0;
  addEventListener("pointermove", () => {
    link.classList.add("shown");
    clearTimeout(timer);
    timer = window.setTimeout(() => link.classList.remove("shown"), 3000);
  });
}

/** Asks for a token, with which the page is loaded again. */
function askForToken(): void {
  if (root.querySelector(".token")) return;
  const field = element("input", { type: "password", placeholder: "Token", "aria-label": "Token", autocomplete: "off" });
  const form = element("form", { class: "token" }, field, element("button", {}, "Open"));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const fragment = new URLSearchParams(location.hash.slice(1));
    fragment.set("token", field.value);
    history.replaceState(null, "", `#${fragment}`);
    location.reload();
  });
  root.append(form);
  field.focus();
}

function show(src: string): void {
  const player = element("pointreel-player", { controls: "", tabindex: "-1" }) as PointreelPlayer;
  const { seconds, view } = draw(player);
  if (seconds !== undefined) player.currentTime = seconds;
  player.floor = true;
  player.player.firstView = view ?? null;
  player.loop = true;
  player.autoplay = seconds === undefined;
  if (token) player.setAttribute("token", token);
  const places = query.get("at");
  if (places) player.setAttribute("places", places.replace(/;/g, " "));
  player.src = src;
  root.replaceChildren(player);
  if (window.parent === window) addWayBack();
  const note = () => {
    const live = player.player.isLive;
    // The token stays out of links that are shared.
    history.replaceState(null, "", writeFragment(live ? null : player.currentTime, player.player.settings, player.player.camera));
  };
  player.addEventListener("link", note);
  const asking = window.setInterval(() => {
    if (player.player.trouble?.includes(WANTS_TOKEN)) askForToken();
    if (root.querySelector(".token") || player.player.pictures > 0) clearInterval(asking);
  }, 500);
  let timer = 0;
  for (const event of ["viewchange", "seeked", "pause", "settingschange"])
    player.addEventListener(event, () => {
      clearTimeout(timer);
      timer = window.setTimeout(() => {
        if ((player.paused || player.player.isLive) && player.player.pictures > 0) note();
      }, 500);
    });
  // Somebody has written another "#..." behind the address.
  window.addEventListener("hashchange", (event) => {
    history.replaceState(null, "", event.newURL);  // note() may have written over it meanwhile
    const named = tokenOf();
    if (named !== null && named !== player.token) return location.reload();
    const { seconds, view } = draw(player);
    if (seconds !== undefined) player.currentTime = seconds;
    if (view) player.player.move(view);
  });
  document.title = `${decoded(src.split(/[/?]/).filter((p) => p && p !== "reel.json").pop() ?? "")} – Pointreel`;
  // Keys work from anywhere on the page.
  document.addEventListener("keydown", (event) => {
    if (event.target === document.body) player.dispatchEvent(new KeyboardEvent("keydown", event));
  });
}

const src = sources();
if (src) show(src);
else showList(root, base, token).catch((error: Error) => {
  root.replaceChildren(element("p", { class: "error", role: "alert" }, `The list of reels cannot be shown: ${error.message}.`));
  if (error.message.includes(WANTS_TOKEN)) askForToken();
});
