// A worker: makes frames ready to draw and packs what a camera sees of them.
import { Done, FromWorker, Pack, Prepare, ToWorker } from "./messages";
import { encode, frameFacts, Module, ModuleError, pack } from "./module";
import { NoVideo, VideoError } from "./video_decoder";
import { VideoGroups } from "./video_groups";

declare function postMessage(message: FromWorker, transfer?: Transferable[]): void;

let module: Module;
let videos: VideoGroups;
const reelTables = new Map<number, number>();

async function prepare(job: Prepare): Promise<void> {
  const tables = reelTables.get(job.tables) ?? 0;
  if (job.video) return videos.prepare(job, tables);
  const name = encode(job.field);
  const [bytes, sizes, options, field, scalar] = module.put(job.bytes, job.sizes, job.options, name, job.scalar);
  module.check("pr_prepare", job.key, bytes!, sizes!, job.sizes.length / 3,
               tables, options!, field!, name.length, scalar!);
}

function packed(job: Prepare | Pack, prepareMs: number): void {
  const start = performance.now();
  const result = pack(module, job.key, job.view);
  const done: Done = {
    type: "done", job: job.job, facts: frameFacts(module, job.key), packed: result,
    times: { prepareMs, packMs: performance.now() - start },
    memory: module.call("pr_memory_in_use"),
  };
  postMessage(done, [result.instances, result.indices.buffer]);
}

async function open(compiled: WebAssembly.Module, tables: Uint8Array): Promise<void> {
  module = await Module.create(compiled);
  videos = new VideoGroups(module);
  const [bytes] = module.put(tables);
  module.check("pr_load_tables", bytes!, tables.length);
  postMessage({ type: "opened" });
}

async function act(message: ToWorker): Promise<void> {
  switch (message.type) {
    case "open":
      return open(message.compiled, message.tables);
    case "tables": {
      const checksum = encode(message.checksum);
      const [bytes, text] = module.put(message.bytes, checksum);
      reelTables.set(message.tables, module.made("pr_tables_new", bytes!, message.bytes.length,
                                                 text!, checksum.length));
      return;
    }
    case "prepare": {
      const start = performance.now();
      await prepare(message);
      return packed(message, performance.now() - start);
    }
    case "pack":
      return packed(message, 0);
    case "drop":
      for (const key of message.keys) module.call("pr_drop", key);
  }
}

async function answer(message: ToWorker): Promise<void> {
  try {
    await act(message);
  } catch (error) {
    postMessage({ type: "failed", job: "job" in message ? message.job : -1, message: String((error as Error).message),
                  trapped: !(error instanceof ModuleError || error instanceof VideoError), noVideo: error instanceof NoVideo });
  }
}

/** One after another: a frame of video waits for the browser's decoder. */
let last = Promise.resolve();
onmessage = ({ data }: MessageEvent<ToWorker>) => { last = last.then(() => answer(data)); };
