// Packets of Opus as a file of Ogg (RFC 3533, RFC 7845), for browsers that decode nothing else.
import { encode } from "../module";

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let crc = byte << 24;
  for (let bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ (crc < 0 ? 0x04c11db7 : 0);
  return crc;
});
function crcOf(bytes: Uint8Array): number {
  let crc = 0;
  for (const byte of bytes) crc = (crc << 8) ^ TABLE[(crc >>> 24) ^ byte]!;
  return crc >>> 0;
}

/** A page of one packet, of less than 64 KB. `end`: the samples up to its end. */
function page(number: number, kind: number, end: number, packet: Uint8Array): Uint8Array {
  const laces = Math.floor(packet.length / 255) + 1, head = 27 + laces;
  const made = new Uint8Array(head + packet.length), view = new DataView(made.buffer);
  made.set(encode("OggS"));
  view.setUint8(5, kind);
  view.setUint32(6, end, true);
  view.setUint32(14, 1, true);
  view.setUint32(18, number, true);
  view.setUint8(26, laces);
  made.fill(255, 27, head - 1);
  view.setUint8(head - 1, packet.length % 255);
  made.set(packet, head);
  view.setUint32(22, crcOf(made), true);
  return made;
}

const BEGINS = 2, ENDS = 4;  // kinds of pages
const HEAD = Uint8Array.of(...encode("OpusHead"), 1, 2, 0, 0, 0x80, 0xbb, 0, 0, 0, 0, 0);  // two channels at 48,000 Hz
const TAGS = Uint8Array.of(...encode("OpusTags"), 0, 0, 0, 0, 0, 0, 0, 0);

/** `samples`: of each packet, at 48,000 Hz. */
export function oggOf(packets: readonly { packet: Uint8Array; samples: number }[]): Uint8Array {
  let end = 0;
  const pages = [page(0, BEGINS, 0, HEAD), page(1, 0, 0, TAGS), ...packets.map(({ packet, samples }, i) =>
    page(i + 2, i + 1 === packets.length ? ENDS : 0, end += samples, packet))];
  const file = new Uint8Array(pages.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const one of pages) {
    file.set(one, at);
    at += one.length;
  }
  return file;
}
