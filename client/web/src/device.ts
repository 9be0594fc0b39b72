// What this machine can be asked for.

const isPhone = matchMedia("(pointer: coarse) and (max-width: 900px)").matches;

export const WORKERS = Math.max(1, Math.min(isPhone ? 2 : 4, (navigator.hardwareConcurrency || 2) - 1));
/** Bytes of frames that are ready to draw. */
export const FRAME_BYTES = (isPhone ? 128 : 384) * 2 ** 20;
/** Bytes of frames as they were fetched. */
export const STORE_BYTES = (isPhone ? 32 : 128) * 2 ** 20;
/** Bytes that decoding one frame may take. */
export const DECODE_BYTES = (isPhone ? 256 : 512) * 2 ** 20;
