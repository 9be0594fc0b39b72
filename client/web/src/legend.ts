// What colours mean: pr_legend, and a picture of it.

export interface Legend {
  /** The name of a scalar field. */
  title: string;
  /** The colours are those of a ramp, at equal distances; else of labels. */
  isRamp: boolean;
  colors: { color: string; text: string }[];
}

/** `text`: of pr_legend. Null if it is empty. */
export function readLegend(text: string): Legend | null {
  if (text === "") return null;
  const [title, kind, ...lines] = text.split("\n");
  return { title: title!, isRamp: kind === "ramp",
           colors: lines.map((line) => ({ color: `#${line.slice(0, 6)}`, text: line.slice(7) })) };
}

// In pixels of a picture that is not enlarged.
const FONT = "12px system-ui, 'DejaVu Sans', sans-serif";
const PAD = 8, LINE = 18, RAMP_WIDTH = 160, RAMP_HEIGHT = 10, SWATCH = 11;
const PAPER = "#181a1e", INK = "#ebebeb";

/** A picture of a legend, so many times enlarged, that can be shown and be drawn into others. */
export function drawLegend(legend: Legend, scale: number): HTMLCanvasElement {
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d")!;
  pen.font = FONT;
  const { title, isRamp, colors } = legend, widthOf = (text: string) => Math.ceil(pen.measureText(text).width);
  const inner = isRamp ? Math.max(RAMP_WIDTH, widthOf(title))
    : Math.max(40, widthOf(title), ...colors.map(({ text }) => SWATCH + 6 + widthOf(text)));
  const width = inner + 2 * PAD, height = 2 * PAD + LINE + (isRamp ? RAMP_HEIGHT + 4 + 12 : LINE * colors.length);
  canvas.width = Math.ceil(width * scale);
  canvas.height = Math.ceil(height * scale);
  pen.scale(scale, scale);
  pen.font = FONT;
  pen.textBaseline = "middle";
  pen.fillStyle = PAPER;
  pen.fillRect(0, 0, width, height);
  const write = (text: string, x: number, y: number) => {
    pen.fillStyle = INK;
    pen.fillText(text, x, y);
  };
  write(title, PAD, PAD + 6);
  let y = PAD + LINE;
  if (isRamp) {
    const ramp = pen.createLinearGradient(PAD, 0, PAD + inner, 0);
    colors.forEach(({ color }, i) => ramp.addColorStop(i / (colors.length - 1), color));
    pen.fillStyle = ramp;
    pen.fillRect(PAD, y, inner, RAMP_HEIGHT);
    y += RAMP_HEIGHT + 10;
    const most = colors[colors.length - 1]!.text;
    write(colors[0]!.text, PAD, y);
    write(most, PAD + inner - widthOf(most), y);
  } else {
    for (const { color, text } of colors) {
      pen.fillStyle = color;
      pen.fillRect(PAD, y, SWATCH, SWATCH);
      write(text, PAD + SWATCH + 6, y + 6);
      y += LINE;
    }
  }
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `Legend of ${title}: ${colors.map(({ text }) => text).filter((text) => text).join(isRamp ? " to " : ", ")}`);
  return canvas;
}
