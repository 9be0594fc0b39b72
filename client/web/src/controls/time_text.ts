export function timeText(us: number): string {
  const ms = Math.floor(us / 1000), seconds = Math.floor(ms / 1000), minutes = Math.floor(seconds / 60);
  const two = (n: number) => String(n).padStart(2, "0");
  const rest = `${two(minutes % 60)}:${two(seconds % 60)}.${String(ms % 1000).padStart(3, "0")}`;
  return minutes < 60 ? rest : `${Math.floor(minutes / 60)}:${rest}`;
}
export function bytesText(bytes: number): string {
  if (bytes < 1024) return `${bytes} B`;
  const units = ["KiB", "MiB", "GiB"];
  let value = bytes, unit = -1;
  while (value >= 1024 && unit < 2) {
    value /= 1024;
    ++unit;
  }
  return `${value.toPrecision(3)} ${units[unit]}`;
}
export function countText(n: number): string {
  return n < 1000 ? String(n) : n < 1e6 ? `${(n / 1e3).toPrecision(3)} k` : `${(n / 1e6).toPrecision(3)} M`;
}
