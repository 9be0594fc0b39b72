// node measure.mjs BUILD REEL [ROUNDS]: how fast packages are uploaded into an object store on this machine, next to
// curl -T of the same files, and how soon they play from there, next to pointreel-server serve. Takes turns; prints
// medians, and the least of each.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const [build, reel, rounds = "7"] = process.argv.slice(2);
const bin = (program) => join(build, "bin", program);
const here = dirname(fileURLToPath(import.meta.url));
const name = basename(reel);
const folder = mkdtempSync(join(tmpdir(), "pointreel-store-"));
const keys = { AWS_ACCESS_KEY_ID: "S3RVER", AWS_SECRET_ACCESS_KEY: "S3RVER" };
const children = [];

/** Starts a program, and waits for the line in which it prints its address. */
async function start(program, args, pattern) {
  const child = spawn(program, args, { stdio: ["ignore", "pipe", "inherit"] });
  children.push(child);
  for await (const line of createInterface({ input: child.stdout })) {
    const found = pattern.exec(line);
    if (found) return found[1];
  }
  throw new Error(`${program} has ended`);
}
function run(program, args, env = {}) {
  return execFileSync(program, args, { env: { ...process.env, ...keys, ...env }, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
}
function seconds(what) {
  const begin = process.hrtime.bigint();
  what();
  return Number(process.hrtime.bigint() - begin) * 1e-9;
}
function report(what, times, text) {
  const sorted = [...times].sort((a, b) => a - b);
  const median = sorted[sorted.length >> 1];
  console.log(`${what.padEnd(44)} ${text(median)} (best ${text(sorted[0])})`);
  return median;
}

try {
  const files = readdirSync(reel).map((file) => join(reel, file));
  const bytes = files.reduce((sum, file) => sum + statSync(file).size, 0);
  console.log(`${files.length} files, ${(bytes * 1e-6).toFixed(1)} MB, ${rounds} rounds`);

  const port = await start(process.execPath, [join(here, "node_modules/s3rver/bin/s3rver.js"), "-d", join(folder, "objects"),
    "-a", "127.0.0.1", "-p", "4570", "--configure-bucket", "reels"], /listening on \S+?:(\d+)/);
  const endpoint = `http://127.0.0.1:${port}`;
  const served = await start(bin("pointreel-server"), ["serve", reel, "--listen", "127.0.0.1:0"], /^listening on (http:\S+)/);
  const times = { upload: [], curl: [], store: [], serve: [], storeFrame: [], serveFrame: [] };
  const clean = () => rmSync(join(folder, "objects/reels/walk"), { recursive: true, force: true });
  for (let i = 0; i < Number(rounds); ++i) {
    clean();
    times.curl.push(seconds(() => run("curl", ["-sSf", "--aws-sigv4", "aws:amz:us-east-1:s3", "-u", "S3RVER:S3RVER",
      "-H", "x-amz-content-sha256: UNSIGNED-PAYLOAD", "-T", `{${files.join(",")}}`, `${endpoint}/reels/walk/`])));
    clean();
    times.upload.push(seconds(() => run(bin("pointreel-server"), ["upload", reel, "s3://reels/walk", "--endpoint", endpoint])));
    const picture = join(folder, "picture.png");
    const play = (source) => run(bin("pointreel"), ["play", source, "--endpoint", endpoint, "--offscreen", "320x240", "--at", "0",
      "--screenshot", picture]);
    times.serve.push(seconds(() => play(`${served}/${name}`)));
    times.store.push(seconds(() => play("s3://reels/walk")));
    // Without the start of the program: manifest and first frame, by the player's own source.
    const frame = (source) => Number(run("/usr/bin/python3", ["-c", "import pointreel, time; b = time.monotonic(); " +
      `pointreel.open('${source}')[0]; print(time.monotonic() - b)`], { AWS_ENDPOINT_URL: endpoint, PYTHONPATH: join(build, "python") }));
    times.serveFrame.push(frame(`${served}/${name}`));
    times.storeFrame.push(frame("s3://reels/walk"));
  }
  const rate = (time) => `${(bytes * 1e-6 / time).toFixed(0)} MB/s`, ms = (time) => `${(time * 1e3).toFixed(0)} ms`;
  const curl = report("curl -T", times.curl, rate), upload = report("pointreel-server upload", times.upload, rate);
  console.log(`  upload is ${(curl / upload).toFixed(2)} times as fast as curl`);
  const ratio = (what, far, near) => {
    const a = report(`${what}: serve`, near, ms), b = report(`${what}: store`, far, ms);
    console.log(`  the store takes ${(b / a).toFixed(2)} times as long`);
  };
  ratio("program to picture", times.store, times.serve);
  ratio("open to first frame", times.storeFrame, times.serveFrame);
} finally {
  for (const child of children) child.kill("SIGTERM");
  rmSync(folder, { recursive: true, force: true });
}
