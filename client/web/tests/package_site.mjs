// The npm package as a page uses it: installed, and served by a server of plain files.
import { execFileSync } from "node:child_process";
import { cpSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { serveFiles, serveReels } from "./origins.mjs";

/**
 * Installs a tarball beside the examples and serves both. The reel comes from `program`, a server of another origin, by the
 * names that the examples ask for.
 */
export async function installPackage(tarball, program, reel) {
  const folder = mkdtempSync(join(tmpdir(), "pointreel-"));
  const near = (path) => fileURLToPath(new URL(path, import.meta.url));
  cpSync(near("../examples"), folder, { recursive: true });
  writeFileSync(join(folder, "package.json"), "{}");
  execFileSync("npm", ["install", "--offline", "--no-audit", "--no-fund", "--legacy-peer-deps", tarball], { cwd: folder });
  cpSync(near("node_modules/three"), join(folder, "node_modules/three"), { recursive: true });
  const reels = ["soccer-shoot", "walk"].map((name) => join(folder, "reels", name));
  for (const copy of reels) cpSync(reel, copy, { recursive: true });
  const site = await serveFiles(folder);
  const server = await serveReels(program, reels, site.origin);
  site.replace.set("http://127.0.0.1:8090", server.origin);
  return { folder, site, server, close: () => {
    for (const each of [site, server]) each.close();
    rmSync(folder, { recursive: true });
  } };
}
