// A worker: makes frames ready to draw and packs what a camera sees of them.
import { Done, FromWorker, Pack, Prepare, ToWorker } from "./messages";
import { encode, frameFacts, Module, ModuleError, pack } from "./module";

declare function postMessage(message: FromWorker, transfer?: Transferable[]): void;

let module: Module;
const reelTables = new Map<number, number>();

function prepare(job: Prepare): void {
  const name = encode(job.field);
  const [bytes, sizes, options, field, scalar] = module.put(job.bytes, job.sizes, job.options, name, job.scalar);
  module.check("pr_prepare", job.key, bytes!, sizes!, job.sizes.length / 3,
               reelTables.get(job.tables) ?? 0, options!, field!, name.length, scalar!);
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
  const [bytes] = module.put(tables);
  module.check("pr_load_tables", bytes!, tables.length);
  postMessage({ type: "opened" });
}

function act(message: ToWorker): void | Promise<void> {
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
      prepare(message);
      return packed(message, performance.now() - start);
    }
    case "pack":
      return packed(message, 0);
    case "drop":
      for (const key of message.keys) module.call("pr_drop", key);
  }
}

onmessage = async ({ data }: MessageEvent<ToWorker>) => {
  try {
    await act(data);
  } catch (error) {
    postMessage({ type: "failed", job: "job" in data ? data.job : -1, message: String((error as Error).message),
                  trapped: !(error instanceof ModuleError) });
  }
};
