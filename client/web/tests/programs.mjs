// The programs of a build, which run in the background until a test, or the end of all tests, ends them.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after } from "node:test";

const running = new Set();

/** Starts a program. `end()` ends it and waits until it has. */
export function start(program, args) {
  const child = spawn(program, args, { stdio: ["ignore", "pipe", "inherit"] });
  const ended = once(child, "exit").finally(() => running.delete(child));
  running.add(child);
  return { child, ended, end: async (signal = "SIGTERM") => {
    child.kill(signal);
    await ended;
  } };
}

/** Starts a program that prints "listening on ADDRESS" first. `address` is HOST:PORT. */
export async function startListening(program, args) {
  const started = start(program, args);
  const first = new Promise((resolve) => createInterface(started.child.stdout).once("line", resolve));
  const line = await Promise.race([first, started.ended.then(() => "it ended")]);
  const address = /^listening on (?:http:\/\/)?([\d.]+:\d+)$/.exec(line)?.[1];
  if (!address) throw new Error(`${program}: ${line}`);
  return { ...started, address };
}

export const programs = (build) => ({
  serve: (...args) => startListening(join(build, "bin/pointreel-server"), ["serve", ...args]),
  publish: (...args) => start(join(build, "bin/pointreel-server"), ["publish", ...args]),
  link: (...args) => startListening(join(build, "bin/pointreel-link"), args),
});

// Tests that failed have left theirs, for which Node would wait.
after(() => { for (const child of running) child.kill(); });
