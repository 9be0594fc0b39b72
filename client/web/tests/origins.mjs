// Servers of their own origins: of plain files, and pointreel-server.
import { spawn } from "node:child_process";
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";
import { createInterface } from "node:readline";

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".mjs": "text/javascript", ".css": "text/css" };

/** `replace`: what texts of pages have in place of their examples' addresses. */
export async function serveFiles(folder) {
  const replace = new Map();
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://here").pathname));
    if (path === "/favicon.ico") return response.writeHead(204).end();
    try {
      let bytes = await readFile(join(folder, path));
      if (/\.(html|js)$/.test(path) && !path.startsWith("/node_modules/"))
        for (const [from, to] of replace) bytes = bytes.toString().replaceAll(from, to);
      response.writeHead(200, { "Content-Type": TYPES[extname(path)] ?? "application/octet-stream", "Access-Control-Allow-Origin": "*" });
      response.end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { origin: `http://127.0.0.1:${server.address().port}`, replace, close: () => server.close() };
}

export async function serveReels(program, reels, allowedOrigin) {
  const child = spawn(program, ["serve", ...reels, "--listen", "127.0.0.1:0", "--allow-origin", allowedOrigin],
                      { stdio: ["ignore", "pipe", "inherit"] });
  for await (const line of createInterface({ input: child.stdout })) {
    const origin = /http:\/\/127\.0\.0\.1:\d+/.exec(line)?.[0];
    if (origin) return { origin, close: () => child.kill() };
  }
  throw new Error("pointreel-server ended before it served");
}
