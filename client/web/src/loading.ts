// The modules and their tables, loaded once for all players of a page.
import { refusal } from "./fetching";
import { Module } from "./module";
import { Assets, Workers } from "./pool";

async function fetchAsset(base: URL, name: string): Promise<Response> {
  const response = await fetch(new URL(name, base));
  if (!response.ok) throw new Error(`${name}: ${refusal(response)}`);
  return response;
}
async function compile(base: URL, name: string): Promise<WebAssembly.Module> {
  const response = await fetchAsset(base, name);
  return response.headers.get("Content-Type")?.startsWith("application/wasm")
    ? WebAssembly.compileStreaming(response) : WebAssembly.compile(await response.arrayBuffer());
}

/** A worker's script must be of the page's own origin. A line that imports it may be anywhere. */
function ownOrigin(script: URL): URL {
  if (script.origin === location.origin) return script;
  const line = new Blob([`import ${JSON.stringify(script.href)};`], { type: "text/javascript" });
  return new URL(URL.createObjectURL(line));
}

interface Loaded {
  assets: Assets;
  module: Module;
}
let loading: Promise<Loaded> | null = null;
let whole: Promise<WebAssembly.Module> | null = null;
/** `base`: the folder of the page's files. */
export function load(base: URL): Promise<Loaded> {
  if (loading) return loading;
  const workers = new Workers(ownOrigin(new URL("worker.js", base)));
  loading = (async () => {
    const tables = fetchAsset(base, "tables.zst").then(async (r) => new Uint8Array(await r.arrayBuffer()));
    const compiled = await compile(base, "pointreel.wasm");
    return { assets: { compiled, tables: await tables, workers }, module: await Module.create(compiled) };
  })().catch((error) => {
    loading = null;
    workers.free();
    throw error;
  });
  return loading;
}
/** The larger module, which decodes Draco, too. */
export function loadWhole(base: URL): Promise<WebAssembly.Module> {
  whole ??= compile(base, "pointreel-draco.wasm").catch((error) => {
    whole = null;
    throw error;
  });
  return whole;
}
