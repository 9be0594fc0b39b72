// Serves the built page with reels beside it, as any server of plain files does:
//   node serve.mjs PAGE REELS...
// prints the port. "/" answers browsers with the page and others with the list of reels; so does
// "/REEL".
import { createReadStream, existsSync, readdirSync, readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { basename, extname, join, normalize } from "node:path";

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css",
                ".wasm": "application/wasm", ".json": "application/json", ".opus": "audio/ogg" };
// The policy of server/service/page.cpp, so that the tests show that the page needs no more.
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; " +
  "img-src 'self' blob: data:; font-src 'self'; connect-src 'self'; media-src 'self' blob:; base-uri 'none'; form-action 'none'; " +
  "frame-ancestors 'self'";

/**
 * `damage`: changes what is sent of a reel's files; its arguments are the path and the bytes. Null: the file is missing.
 * `ranges`: false sends whole files, whatever is asked for.
 * `silent`: whether a request for this path is never answered.
 * `lateMs`: for how long an answer for this path is held back.
 * `plain`: serves files and nothing else: "/" is the page for everybody, and the list is reels.json.
 * `others`: more entries of the list.
 */
export function serve(page, reels, requests = [], { damage = null, ranges = true, silent = () => false, lateMs = () => 0, plain = false, others = [] } = {}) {
  const folders = new Map(reels.map((reel) => [basename(reel), reel]));
  const list = () => JSON.stringify({
    packages: [...folders].map(([name, folder]) => {
      const reel = JSON.parse(readFileSync(join(folder, "reel.json"), "utf8"));
      return { name, url: `/${name}`, manifest: `/${name}/reel.json`, fps: reel.fps, duration_us: reel.duration_us,
               codec: reel.codec, changed_us: Date.UTC(2026, 0, 31, 12) * 1000,
               ...(name.endsWith("7") ? { captured_us: Date.UTC(2025, 6, 1, 12) * 1000 } : {}), frames: reel.segments.reduce((n, s) => n + s.times_us.length, 0),
               bytes: readdirSync(folder).reduce((n, f) => n + statSync(join(folder, f)).size, 0) };
    }).concat(others),
    streams: [],
  });
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://here").pathname));
    requests.push({ path, range: request.headers.range ?? null, at: Date.now() });
    if (silent(path)) return;
    if (lateMs(path) > 0) await new Promise((resolve) => setTimeout(resolve, lateMs(path)));
    const [, first, ...rest] = path.split("/");
    const asksPage = (request.headers.accept ?? "").includes("text/html");
    const isShown = path === "/" || path === "/index.html" || (!plain && folders.has(first) && rest.join("") === "");
    if (plain ? path === "/reels.json" : path === "/" && !asksPage) {
      response.writeHead(200, { "Content-Type": TYPES[".json"], Vary: "Accept" }).end(list());
      return;
    }
    const file = isShown ? join(page, "index.html")
      : first === "page" ? join(page, path) : folders.has(first) ? join(folders.get(first), ...rest) : "";
    if (!file || !existsSync(file) || !statSync(file).isFile()) {
      response.writeHead(404, { "Content-Type": "text/plain" }).end("not found\n");
      return;
    }
    const size = statSync(file).size, range = ranges && /^bytes=(\d+)-(\d*)$/.exec(request.headers.range ?? "");
    const headers = { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream", "Cache-Control": "no-cache",
                      "Accept-Ranges": ranges ? "bytes" : "none", ...(isShown ? { "Content-Security-Policy": POLICY, Vary: "Accept" } : {}) };
    if (!range) {
      response.writeHead(200, { ...headers, "Content-Length": size });
      createReadStream(file).pipe(response);
      return;
    }
    const from = Number(range[1]), to = Math.min(Number(range[2] || size), size - 1);
    const damaged = damage && file.endsWith(".prs") ? damage(path, readFileSync(file).subarray(from, to + 1)) : undefined;
    if (damaged === null) {
      response.writeHead(404, { "Content-Type": "text/plain" }).end("not found\n");
      return;
    }
    response.writeHead(206, { ...headers, "Content-Length": to - from + 1, "Content-Range": `bytes ${from}-${to}/${size}` });
    if (damaged) response.end(damaged);
    else createReadStream(file, { start: from, end: to }).pipe(response);
  });
  server.unref();  // a test that fails before it closes its server must not hang
  return new Promise((resolve) => server.listen(0, "127.0.0.1", () => resolve({ server, port: server.address().port })));
}

if (process.argv[1] && import.meta.url.endsWith(basename(process.argv[1]))) {
  const [page, ...reels] = process.argv.slice(2);
  serve(page, reels).then(({ server, port }) => { server.ref(); console.log(port); });
}
