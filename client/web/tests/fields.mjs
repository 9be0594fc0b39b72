// What tests of colours and light show.
import { execFileSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

/** A sphere with two scalar fields: numbers, of which some are not known, and labels. */
export function packFields(build, scratch) {
  const clouds = join(scratch, "fields_clouds"), fields = join(scratch, "fields"), count = 20_000;
  const points = Array.from({ length: count }, (_, i) => {
    const z = 1 - (2 * i + 1) / count, r = Math.sqrt(1 - z * z), turn = 2.399963 * i, x = r * Math.cos(turn);
    return [x, r * Math.sin(turn), z, z > 0.9 ? "nan" : (1000 * (x + 1)).toFixed(1), Math.floor(2 * (z + 1))];
  });
  mkdirSync(clouds);
  writeFileSync(join(clouds, "frame.ply"), ["ply", "format ascii 1.0", `element vertex ${count}`,
    ...["x", "y", "z", "intensity", "class"].map((name) => `property float ${name}`), "end_header",
    ...points.map((p) => p.join(" ")), ""].join("\n"));
  execFileSync(join(build, "bin/pointreel-server"), ["pack", "-i", clouds, "-o", fields]);
  return fields;
}

/** A picture of light in a folder: a blue sky, brown ground, and a sun to the right in front. Returns its path. */
export function writeEnvironment(folder) {
  const width = 64, height = 32, file = join(folder, "evening.hdr"), pixels = [];
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      const isSun = x >= 40 && x < 43 && y >= 8 && y < 11;
      // Red, green, blue and their exponent.
      pixels.push(...(isSun ? [200, 180, 150, 135] : y < height / 2 ? [70, 100, 150, 128] : [60, 45, 30, 127]));
    }
  writeFileSync(file, Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`), Buffer.from(pixels)]));
  return file;
}
