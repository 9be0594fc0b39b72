// The picture of light that a player is lit by: Radiance's .hdr, as of --environment of the desktop player.
import { refusal } from "./fetching";
import { Module } from "./module";

const MOST_BYTES = 256 * 1024 * 1024;

export class Environment {
  /** A PrEnvironment; 0 while there is none. */
  handle = 0;
  /** Why there is none, or null. */
  trouble: string | null = null;
  private address = "";

  /** `changed` is called when there is another one. */
  constructor(private readonly module: Module, private readonly changed: () => void) {}

  free(): void {
    this.address = "";
    this.clear();
  }
  private clear(): void {
    this.module.call("pr_environment_free", this.handle);
    this.handle = 0;
    this.trouble = null;
  }

  /** Fetches the file at an address, unless that has been done. Empty: none. */
  follow(address: string): void {
    if (address === this.address) return;
    this.address = address;
    this.clear();
    if (address === "") return;
    this.read(address).catch((error: Error) => {
      if (this.address === address) this.trouble = `${address}: ${error.message}`;
    }).then(() => this.changed());
  }
  private async read(address: string): Promise<void> {
    const response = await fetch(new URL(address, document.baseURI));
    if (!response.ok) throw new Error(refusal(response));
    if (Number(response.headers.get("Content-Length")) > MOST_BYTES) throw new Error("is larger than 256 MiB");
    const bytes = new Uint8Array(await response.arrayBuffer());
    if (this.address !== address) return;
    this.handle = this.module.withBytes(bytes, (at) => this.module.made("pr_environment_new", at, bytes.length));
  }
}
