// Bytes over HTTP, checked: common/PROTOCOL.md, "What a client does" and "Failures that may pass".

/** An answer that will not become better. */
export class FetchError extends Error {}

const PASSING = new Set([408, 425, 429, 500, 502, 503, 504]);
const MANIFEST_BYTES = 33_554_432;
const STALL_MS = 5000, MOST_PATIENCE_MS = 60_000;
/** Such as the page of a gateway whose server starts anew. */
const MOST_SENSELESS = 8;
/** Of files that servers sent whole where ranges were asked for. */
const KEPT_BYTES = 64 << 20;
/** Browsers do not tell a server of another origin that does not answer from one that this page may not read. */
const MOST_UNREAD = 10;
const sleep = (ms: number) => new Promise((resolve) => setTimeout(resolve, ms));

/** Not in older browsers, in which requests that are not answered stay open. */
const anyOf = (AbortSignal as { any?: (signals: AbortSignal[]) => AbortSignal }).any;

class Silence extends Error {}

/** What `coming` gives, unless it takes so long that nothing more is to be expected. */
async function unlessStalled<T>(coming: Promise<T>, ms = STALL_MS): Promise<T> {
  let timer = 0;
  const stalled = new Promise<never>((_, reject) => {
    timer = window.setTimeout(() => reject(new Silence(`the server has sent nothing for ${ms / 1000} s`)), ms);
  });
  return Promise.race([coming, stalled]).finally(() => clearTimeout(timer));
}

/** What begins the line that says that a token is missing or wrong. */
export const WANTS_TOKEN = "the server wants a valid token";

/** Throws where no request may have this token. */
export function checkToken(token: string | null): void {
  if (token && /[^!-~]/.test(token)) throw new Error(`${WANTS_TOKEN}: this one has a blank or another character that no token may have`);
}

/** What a person should know of an answer that is not the content. */
export function refusal(response: Response): string {
  if (response.status === 401)
    return `${WANTS_TOKEN} (in links: #token=TOKEN; in pages: the attribute token of the player)`;
  return `the server answers ${response.status} ${response.statusText}`.trim();
}

export interface LinkUse {
  bytes: number;
  /** While at least one answer was coming. */
  seconds: number;
}

export class Fetcher {
  private active = 0;
  private since = 0;
  private use: LinkUse = { bytes: 0, seconds: 0 };
  /** Files of a server that sends no ranges, by path; the newest is the last. */
  private readonly kept = new Map<string, Uint8Array>();
  total = 0;
  requests = 0;
  /** How long the first byte of an answer may take. */
  private patience = STALL_MS;
  /** What is wrong with the link at the moment, if anything. */
  trouble: string | null = null;

  /** `troubled` is called when something is wrong. */
  constructor(private readonly base: URL, private readonly token: string | null, private readonly troubled: () => void) {}

  /** What came since the last call. */
  takeUse(): LinkUse {
    this.count();
    const use = this.use;
    this.use = { bytes: 0, seconds: 0 };
    return use;
  }
  private count(): void {
    const now = performance.now();
    if (this.active > 0) this.use.seconds += (now - this.since) / 1000;
    this.since = now;
  }

  url(path: string): URL {
    const url = new URL(path, this.base);
    url.search = this.base.search;  // without which a signed address is not valid
    return url;
  }

  manifest(signal: AbortSignal): Promise<Uint8Array> {
    return this.persist(signal, () => this.whole(this.base, MANIFEST_BYTES, signal));
  }
  file(path: string, bytes: number, signal: AbortSignal): Promise<Uint8Array> {
    return this.persist(signal, async () => {
      const body = await this.whole(this.url(path), bytes, signal);
      if (body.length !== bytes) throw new FetchError(`${path}: ${body.length} bytes instead of ${bytes}`);
      return body;
    });
  }
  /** An address that the browser itself can fetch, without the token. */
  async address(path: string, bytes: number, signal: AbortSignal): Promise<string> {
    if (!this.token) return this.url(path).href;
    return URL.createObjectURL(new Blob([await this.file(path, bytes, signal)], { type: "audio/ogg" }));
  }
  /** The bytes from `from` to before `to` of a file of `size` bytes. */
  async range(path: string, from: number, to: number, size: number, signal: AbortSignal): Promise<Uint8Array> {
    if (from === to) return new Uint8Array();  // HTTP has no empty ranges: servers would send the whole file
    const kept = this.kept.get(path);
    if (kept) return kept.slice(from, to);
    let senseless = 0;
    return this.persist(signal, async () => {
      // Chromium has answered neighbouring ranges of one file short out of its cache.
      const response = await this.get(this.url(path), signal, {
        headers: { Range: `bytes=${from}-${to - 1}` }, cache: "no-store",
      });
      const body = await this.body(response, size, signal);
      if (response.status === 200 && body.length === size) {
        this.keep(path, body);
        return body.slice(from, to);
      }
      const range = response.headers.get("Content-Range");
      // Across origins, a server may not let a page read the field.
      const fits = range === null || range === `bytes ${from}-${to - 1}/${size}`;
      if (response.status === 206 && fits && body.length === to - from) return body;
      if (++senseless > MOST_SENSELESS) throw new FetchError(`${path}: the server's answer to a range makes no sense`);
      throw new Error(`${path}: an answer makes no sense`);
    });
  }

  /** One of them is damaged: files are fetched again. */
  forgetFiles(): void { this.kept.clear(); }
  private keep(path: string, file: Uint8Array): void {
    this.kept.delete(path);
    this.kept.set(path, file);
    let bytes = [...this.kept.values()].reduce((sum, { length }) => sum + length, 0);
    for (const [oldest, { length }] of this.kept) {
      if (bytes <= KEPT_BYTES) break;
      this.kept.delete(oldest);
      bytes -= length;
    }
  }

  private async whole(url: URL, most: number, signal: AbortSignal): Promise<Uint8Array> {
    return this.body(await this.get(url, signal, {}), most, signal);
  }

  private async get(url: URL, signal: AbortSignal, init: RequestInit): Promise<Response> {
    const headers = new Headers(init.headers);
    if (this.token) headers.set("Authorization", `Bearer ${this.token}`);
    if (!headers.has("Range")) headers.set("Accept", "application/json, */*;q=0.5");
    this.requests += 1;
    this.count();
    this.active += 1;
    const unanswered = new AbortController();
    const either = anyOf ? anyOf([signal, unanswered.signal]) : signal;
    try {
      const response = await unlessStalled(fetch(url, { ...init, headers, signal: either }), this.patience);
      if (response.ok) return response;
      const why = `${url.pathname}: ${refusal(response)}`;
      throw PASSING.has(response.status) ? new Error(why) : new FetchError(why);
    } catch (error) {
      unanswered.abort();
      // A server that is slow answers in the end.
      if (error instanceof Silence) this.patience = Math.min(2 * this.patience, MOST_PATIENCE_MS);
      throw error;
    } finally {
      this.count();
      this.active -= 1;
    }
  }

  /** No more than `most` bytes. */
  private async body(response: Response, most: number, signal: AbortSignal): Promise<Uint8Array> {
    const reader = response.body?.getReader();
    if (!reader) return new Uint8Array();
    const parts: Uint8Array[] = [];
    let length = 0;
    this.count();
    this.active += 1;
    try {
      for (;;) {
        const { done, value } = await unlessStalled(reader.read());
        if (done) break;
        parts.push(value);
        length += value.length;
        this.use.bytes += value.length;
        this.total += value.length;
        if (length > most) throw new FetchError(`${new URL(response.url).pathname}: longer than announced`);
      }
    } catch (error) {
      if (!signal.aborted) reader.cancel().catch(() => undefined);
      throw error;
    } finally {
      this.count();
      this.active -= 1;
    }
    if (parts.length === 1) return parts[0]!;
    const all = new Uint8Array(length);
    let at = 0;
    for (const part of parts) {
      all.set(part, at);
      at += part.length;
    }
    return all;
  }

  /** Tries again, with growing pauses, as long as the failure may pass. */
  private async persist(signal: AbortSignal, attempt: () => Promise<Uint8Array>): Promise<Uint8Array> {
    let unread = 0;
    for (let pause = 100;; pause = Math.min(2 * pause, 500)) {
      try {
        const bytes = await attempt();
        this.trouble = null;
        return bytes;
      } catch (error) {
        if (signal.aborted || error instanceof FetchError) throw error;
        if (error instanceof TypeError && this.total === 0 && this.base.origin !== location.origin && ++unread >= MOST_UNREAD)
          throw new FetchError(`${this.base.host} does not answer, or does not let this page read; with pointreel-server: ` +
                               `serve --allow-origin ${location.origin}`);
        this.trouble = error instanceof TypeError ? "no connection to the server" : (error as Error).message;
        this.troubled();
        await sleep(pause * (1 - Math.random() / 3));
        if (signal.aborted) throw error;
      }
    }
  }
}
