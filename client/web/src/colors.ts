// What colours show: as --color and --color-range of the desktop player.
import { COLORS, ColorSource, Light, Vec3 } from "./module";

/** A scalar field, and its values in all frames. */
export interface ScalarRange {
  name: string;
  least: number;
  most: number;
  labels: boolean;
}
/** A scalar field in place of colours. */
export interface ScalarChoice {
  field: string;
  /** Values at the ends of the ramp, the lower one first; null: those of the source. */
  range: readonly [number, number] | null;
}
export interface Coloring {
  color: ColorSource;
  /** Counts with the color "colors". */
  scalar: ScalarChoice | null;
}

export const LEAST_ROUGHNESS = 0.2;

const isKnown = (text: string): text is ColorSource => (COLORS as readonly string[]).includes(text);

/** `range`: "0,255". What is not two such numbers is ignored. */
export function coloringOf(text: string, range = ""): Coloring {
  if (text === "" || isKnown(text)) return { color: isKnown(text) ? text : "colors", scalar: null };
  const ends = range.split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
  const isRange = ends.length === 2 && ends.every(Number.isFinite) && ends[0]! < ends[1]!;
  return { color: "colors", scalar: { field: text, range: isRange ? [ends[0]!, ends[1]!] : null } };
}
export const colorText = ({ color, scalar }: Coloring): string => (color === "colors" && scalar ? scalar.field : color);
export const rangeText = ({ scalar }: Coloring): string => scalar?.range?.join(",") ?? "";
/** The default for what is no roughness. */
export function roughnessOf(text: string | null): number {
  const number = text === null || text.trim() === "" ? NaN : Number(text);
  return number >= LEAST_ROUGHNESS && number <= 1 ? number : 0.5;
}

/** Of "#rrggbb", from 0 to 1 each; null for anything else. */
export function rgbOf(text: string): Vec3 | null {
  if (!/^#[0-9a-f]{6}$/i.test(text)) return null;
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255) as Vec3;
}

/** Normals are what is shown, or light falls on them. */
export const showsNormals = (color: ColorSource, light: Light): boolean =>
  (color !== "colors" && color !== "plain") || light !== "flat";
/** Pixels are shaded when it is known what they show: is_shaded_late. */
export const isShadedLate = (color: ColorSource, light: Light): boolean =>
  light !== "flat" || COLORS.indexOf(color) >= COLORS.indexOf("curvature");
