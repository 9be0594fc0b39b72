// node store.mjs BUILD FOLDER (with `clouds`, 12 frames): packs into an object store, reads from there, follows
// a recording, and looks at what is printed.
import assert from "node:assert/strict";
import { execFile, spawn } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { createServer, request } from "node:http";
import { join } from "node:path";
import { createInterface } from "node:readline";
import S3rver from "s3rver";
import { checkSignatures } from "./signature.mjs";

const [build, folder] = process.argv.slice(2);
const server = join(build, "bin/pointreel-server"), player = join(build, "bin/pointreel");
const clouds = join(folder, "clouds"), local = join(folder, "local"), objects = join(folder, "objects");

// --- The store
const store = new S3rver({ port: 0, address: "127.0.0.1", silent: true, directory: objects,
                           configureBuckets: [{ name: "reels" }] });
const stored = [];
store.on("event", (event) => stored.push(event.Records[0].s3.object.key));
const { port } = await store.run();
const SECRET = "S3RVER";
const checked = await checkSignatures(port, SECRET);
const endpoint = `http://127.0.0.1:${checked.address().port}`, unchecked = `http://127.0.0.1:${port}`;

const TOKEN = "a-session-token-of-nobody";
const keys = { AWS_ACCESS_KEY_ID: "S3RVER", AWS_SECRET_ACCESS_KEY: SECRET, AWS_SESSION_TOKEN: TOKEN };
const nothing = { PATH: process.env.PATH, TMPDIR: process.env.TMPDIR, HOME: join(folder, "home") };
mkdirSync(nothing.HOME);

/** Runs a program to its end. No program may print what requests are signed with, or the signature. */
function run(program, args, env = keys) {
  return new Promise((resolve) => {
    execFile(program, args, { env: { ...nothing, ...env } }, (error, out, err) => {
      const all = out + err;
      for (const secret of [TOKEN, "Signature=", "AWS4-HMAC", "SECRET-OF-A-TEST"]) assert(!all.includes(secret), all);
      resolve({ code: error ? error.code : 0, out, err });
    });
  });
}
async function ok(program, args, env) {
  const done = await run(program, args, env);
  assert.equal(done.code, 0, done.err);
  return done.out;
}
async function refused(code, what, program, args, env) {
  const done = await run(program, args, env);
  assert.equal(done.code, code, done.out + done.err);
  assert.equal(done.err.trimEnd().split("\n").length, 1, done.err);
  assert.match(done.err, what);
}
const there = ["--endpoint", endpoint];

async function test(name, what) {
  await what();
  console.log(`ok: ${name}`);
}

try {
  await test("a package is packed into the store, the manifest last", async () => {
    await ok(server, ["pack", "-i", clouds, "-o", local, "--segment", "4"]);
    const json = JSON.parse(await ok(server, ["pack", "-i", clouds, "--segment", "4", "--to", "s3://reels/some walks/kick=1",
                                              "--json", ...there]));
    const files = readdirSync(local);
    assert.equal(json.upload.files, files.length);
    assert.deepEqual([...stored].sort(), files.map((file) => `some walks/kick=1/${file}`).sort());
    assert.equal(stored.at(-1), "some walks/kick=1/reel.json");
    assert.deepEqual(readdirSync(process.env.TMPDIR), []);
  });

  await test("caches are told what they may keep", async () => {
    const headers = async (file) => {
      const answer = await fetch(`${unchecked}/reels/some%20walks/kick%3D1/${file}`, { method: "HEAD" });
      return [answer.headers.get("cache-control"), answer.headers.get("content-type")];
    };
    const layer = readdirSync(local).find((file) => file.endsWith(".prs"));
    assert.deepEqual(await headers(layer), ["public, max-age=31536000, immutable", "application/octet-stream"]);
    assert.deepEqual(await headers("reel.json"), ["no-cache", "application/json"]);
  });

  await test("an upload goes on where it was interrupted", async () => {
    stored.length = 0;
    const upload = ["upload", local, "s3://reels/kick", "--json", ...there];
    const first = JSON.parse(await ok(server, upload));
    assert.equal(first.kept_files, 0);
    const again = JSON.parse(await ok(server, upload));
    assert.deepEqual([again.files, again.kept_files], [0, first.files]);
    const lost = readdirSync(join(objects, "reels/kick"))
      .filter((file) => file.startsWith("reel.json") || file.startsWith("00004.base"));
    for (const file of lost) rmSync(join(objects, "reels/kick", file));
    stored.length = 0;
    const rest = JSON.parse(await ok(server, upload));
    assert.deepEqual([rest.files, rest.kept_files], [2, first.files - 2]);
    assert.match(stored.join(" "), /^kick\/00004\.base\S* kick\/reel\.json$/);
  });

  await test("after many files that are not there, the store is not asked about the rest", async () => {
    const many = join(folder, "many"), asked = [];
    await ok(server, ["pack", "-i", clouds, "-o", many, "--segment", "1"]);
    const files = readdirSync(many).length, upload = ["upload", many, "s3://reels/many", "--json", ...there];
    assert(files > 20, `${files} files`);
    const note = ({ method }) => asked.push(method);
    checked.on("request", note);
    assert.equal(JSON.parse(await ok(server, upload)).files, files);
    const looks = asked.filter((method) => method === "HEAD").length;
    assert(looks >= 4 && looks < 8, `${looks} of ${files}`);
    // What its manifest names is asked about all the same.
    const manifest = join(objects, "reels/many/reel.json._S3rver_object");
    writeFileSync(manifest, `${readFileSync(manifest, "utf8")} `);
    assert.equal(JSON.parse(await ok(server, [...upload, "--force"])).kept_files, files - 1);
    checked.off("request", note);
  });

  await test("info, verify and unpack read from the store", async () => {
    assert.equal(JSON.parse(await ok(server, ["info", "s3://reels/kick", "--json", ...there])).frames, 12);
    const env = { ...keys, AWS_ENDPOINT_URL: endpoint };
    assert.match(await ok(server, ["verify", "s3://reels/some walks/kick=1"], env), /OK, 12 frames/);
    await ok(server, ["unpack", "-i", "s3://reels/kick", "-o", join(folder, "far"), "--frames", "3-5"], env);
    await ok(server, ["unpack", "-i", local, "-o", join(folder, "near"), "--frames", "3-5"]);
    const frames = readdirSync(join(folder, "near"));
    assert.equal(frames.length, 3);
    for (const frame of frames)
      assert(readFileSync(join(folder, "near", frame)).equals(readFileSync(join(folder, "far", frame))));
    assert.deepEqual(readdirSync(process.env.TMPDIR), []);
  });

  await test("packages in the store are cut and joined", async () => {
    const cut = async (reel, frames, to) => ok(server, ["cut", reel, "-o", join(folder, to), "--frames", frames, ...there]);
    await cut("s3://reels/kick", "0-3", "begin");
    await cut("s3://reels/kick", "4-11", "end");
    await ok(server, ["join", join(folder, "begin"), join(folder, "end"), "-o", join(folder, "joined")]);
    await ok(server, ["join", join(folder, "begin"), "s3://reels/kick", "-o", join(folder, "longer"), ...there]);
    const frames = async (name) => JSON.parse(await ok(server, ["info", join(folder, name), "--json"])).frames;
    assert.deepEqual([await frames("end"), await frames("joined"), await frames("longer")], [8, 12, 16]);
    for (const name of ["joined", "longer"]) assert.match(await ok(server, ["verify", join(folder, name)]), /OK/);
  });

  await test("the player plays from the store", async () => {
    const json = join(folder, "play.json");
    await ok(player, ["play", "s3://reels/kick", "--offscreen", "160x120", "--at", "0.2",
                      "--screenshot", join(folder, "picture.png"), "--json", json, ...there]);
    assert.equal(JSON.parse(readFileSync(json, "utf8")).frames_shown, 1);
  });

  const python = join(build, "python");
  if (existsSync(python)) {
    await test("Python opens a package in the store", async () => {
      const program = "import pointreel; r = pointreel.open('s3://reels/kick'); print(len(r), r[0].positions.shape[1])";
      const env = { ...keys, AWS_ENDPOINT_URL: endpoint, PYTHONPATH: python };
      assert.equal((await ok("/usr/bin/python3", ["-c", program], env)).trim(), "12 3");
    });
  }

  await test("keys are found in the usual files, by profile", async () => {
    mkdirSync(join(nothing.HOME, ".aws"));
    writeFileSync(join(nothing.HOME, ".aws/credentials"),
      "[default]\naws_access_key_id = S3RVER\naws_secret_access_key = SECRET-OF-A-TEST\n" +
      "[good]\naws_access_key_id = S3RVER\naws_secret_access_key = S3RVER\n");
    writeFileSync(join(nothing.HOME, ".aws/config"), `[profile good]\nregion = eu-west-1\nendpoint_url = ${endpoint}\n`);
    assert.match(await ok(server, ["info", "s3://reels/kick"], { AWS_PROFILE: "good" }), /12 frames/);
    await refused(1, /403 \(SignatureDoesNotMatch\); check AWS_SECRET_ACCESS_KEY or the profile/, server,
      ["info", "s3://reels/kick", ...there], {});
    rmSync(join(nothing.HOME, ".aws"), { recursive: true });
  });

  await test("what is wrong is said in one line", async () => {
    await refused(2, /there are no keys for the store; set AWS_ACCESS_KEY_ID/, server, ["info", "s3://reels/kick", ...there], {});
    await refused(1, /403 \(SignatureDoesNotMatch\)/, server, ["upload", local, "s3://reels/new", ...there],
      { ...keys, AWS_SECRET_ACCESS_KEY: "SECRET-OF-A-TEST" });
    await refused(1, /403 \(InvalidAccessKeyId\)/, server, ["upload", local, "s3://reels/new", ...there],
      { ...keys, AWS_ACCESS_KEY_ID: "NOBODY" });
    await refused(1, /404 \(NoSuchBucket\); create the bucket/, server, ["pack", "-i", clouds, "--to", "s3://none/kick", ...there]);
    await refused(2, /reel\.json: the store answers 404 \(NoSuchKey\)/, server, ["verify", "s3://reels/nothing", ...there]);
    await refused(1, /nothing answers there/, server, ["info", "s3://reels/kick", "--endpoint", "http://127.0.0.1:1"]);
    await refused(2, /give s3:\/\/BUCKET\/REEL/, server, ["upload", local, "https://reels/kick", ...there]);
    await refused(2, /another reel is there already; --force/, server, ["pack", "-i", clouds, "--to", "s3://reels/kick", ...there]);
  });

  await test("a query that is valid for all objects is sent with each, and not printed", async () => {
    const asked = [];
    const gate = createServer((from, to) => {
      asked.push(from.url);
      if (!from.url.endsWith("?sig=SECRET-OF-A-TEST")) return to.writeHead(403).end();
      from.pipe(request(`${unchecked}${from.url.split("?")[0]}`, { headers: { ...from.headers, host: `127.0.0.1:${port}` } },
        (answer) => answer.pipe(to.writeHead(answer.statusCode, answer.headers))));
    });
    await new Promise((resolve) => gate.listen(0, "127.0.0.1", resolve));
    const base = `http://127.0.0.1:${gate.address().port}/reels`;
    assert.match(await ok(server, ["info", `${base}/kick/reel.json?sig=SECRET-OF-A-TEST`], {}), /12 frames/);
    await refused(1, /reel\.json\?\.\.\.: the server answers 403/, server, ["info", `${base}/kick?sig=SECRET-OF-A-TEST&x`], {});
    await refused(1, /reel\.json\?\.\.\.: the store answers 404/, player,
      ["play", `${base}/none/reel.json?sig=SECRET-OF-A-TEST`, "--offscreen", "64x64"], {});
    assert(asked.every((url) => url.includes("?sig=")));
    gate.close();
  });

  await test("a recording is uploaded while it grows, to its end", async () => {
    const records = join(folder, "records");
    const relay = spawn(server, ["serve", "--live", "--record", records, "--listen", "127.0.0.1:0"], { env: nothing });
    let live;
    for await (const line of createInterface({ input: relay.stdout })) {
      live = /^listening on http:\/\/(\S+)/.exec(line)?.[1];
      if (live) break;
    }
    const publisher = spawn(server, ["publish", "-i", clouds, "--loop", "--fps", "10", "--to", `ws://${live}/live/kick`],
      { env: nothing, stdio: "ignore" });
    while (!existsSync(join(records, "kick/reel.json"))) await new Promise((resolve) => setTimeout(resolve, 50));
    stored.length = 0;
    const follow = run(server, ["upload", join(records, "kick"), "s3://reels/recorded", "--follow", "--json", ...there]);
    const manifests = () => stored.filter((key) => key === "recorded/reel.json").length;
    while (manifests() < 3) await new Promise((resolve) => setTimeout(resolve, 50));
    assert.match(await ok(server, ["verify", "s3://reels/recorded", ...there]), /OK/);
    const growing = JSON.parse(readFileSync(join(objects, "reels/recorded/reel.json._S3rver_object"), "utf8"));
    assert(growing.live);
    const ended = new Promise((resolve) => publisher.on("exit", resolve));
    publisher.kill("SIGTERM");
    await ended;
    const stopped = new Promise((resolve) => relay.on("exit", resolve));
    relay.kill("SIGTERM");
    await stopped;
    const done = await follow;
    assert.equal(done.code, 0, done.err);
    assert.equal(JSON.parse(done.out).growing, false);
    const frames = async (args) => JSON.parse(await ok(server, ["info", "--json", ...args])).frames;
    assert.equal(await frames(["s3://reels/recorded", ...there]), await frames([join(records, "kick")]));
    assert.match(await ok(server, ["verify", "s3://reels/recorded", ...there]), /OK/);
  });
} finally {
  checked.close();
  checked.closeAllConnections();
  await store.close();
}
