// node screenshot.mjs: without Chromium, screenshot.mjs says what is missing and what to do.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

test("without Chromium, one line says so, and nothing is left", () => {
  const folder = mkdtempSync(join(tmpdir(), "pointreel-")), file = join(folder, "page.png");
  const script = fileURLToPath(new URL("../screenshot.mjs", import.meta.url));
  for (const CHROMIUM of ["", join(folder, "nothing")]) {
    const { status, stderr } = spawnSync(process.execPath, [script, file, "http://127.0.0.1/"],
                                         { encoding: "utf8", env: { CHROMIUM, PATH: folder, TMPDIR: folder } });
    assert.equal(stderr, "There is no Chromium, so there is no picture of the page: apt-get install chromium\n");
    assert.equal(status, 77);
    assert.deepEqual(readdirSync(folder), []);
  }
  rmSync(folder, { recursive: true });
});
