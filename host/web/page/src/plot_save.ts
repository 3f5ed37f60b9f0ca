// Saves a plot as a picture and as a table, within the browser.
import {colour} from "./plot_figure";
import type {Curve} from "./plot_figure";
import type {Table} from "./plot";

/** Curves beside each other; those with other x get a column of their own. */
export function curvesTable(xName: string, curves: readonly Curve[], unit: string): Table {
  const head: string[] = [], columns: (readonly (number | null)[])[] = [];
  let x: readonly number[] | undefined;
  for (const curve of curves) {
    if (!x || !sameNumbers(curve.x, x)) {
      head.push(xName);
      columns.push(curve.x);
      x = curve.x;
    }
    head.push(`${curve.name} ${unit}`.trim());
    columns.push(curve.y);
  }
  return {head, columns};
}

const sameNumbers = (a: readonly number[], b: readonly number[]) =>
  a === b || (a.length === b.length && a.every((value, k) => value === b[k]));

/** RFC 4180. */
export function csv({head, columns}: Table): string {
  const field = (value: number | string | null | undefined) => {
    const text = value === null || value === undefined ? "" : String(value);
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const rows = Math.max(0, ...columns.map(({length}) => length));
  const lines = [head.map(field).join(",")];
  for (let row = 0; row < rows; ++row) lines.push(columns.map((column) => field(column[row])).join(","));
  return lines.join("\r\n") + "\r\n";
}

const kMargin = 16, kLine = 20, kNarrowest = 640, kWidest = 1280;

/** Places of pictures side by side as far as they fit, else below each other; and how large all are together. */
export function placed(sizes: readonly {readonly width: number; readonly height: number}[], most: number):
    {readonly at: readonly (readonly [number, number])[]; readonly width: number; readonly height: number} {
  let x = 0, y = 0, row = 0, width = 0;
  const at = sizes.map((size): readonly [number, number] => {
    if (x > 0 && x + size.width > most) [x, y, row] = [0, y + row, 0];
    const place = [x, y] as const;
    x += size.width;
    row = Math.max(row, size.height);
    width = Math.max(width, x);
    return place;
  });
  return {at, width, height: y + row};
}

/** The canvases with texts under them, on the ground of the theme. */
export function picture(canvases: readonly HTMLCanvasElement[], texts: readonly string[]): HTMLCanvasElement {
  const scale = devicePixelRatio;
  const {at, width: needed, height} = placed(canvases, kWidest * scale);
  const width = Math.max(kNarrowest * scale, needed);
  const font = `${14 * scale}px system-ui, "DejaVu Sans", sans-serif`;
  const made = document.createElement("canvas");
  const measure = made.getContext("2d") as CanvasRenderingContext2D;
  measure.font = font;
  const lines = texts.flatMap((text) => wrapped(text, width - 2 * kMargin * scale, (part) => measure.measureText(part).width));
  made.width = width;
  made.height = height + (lines.length * kLine + 2 * kMargin) * scale;
  const ctx = made.getContext("2d") as CanvasRenderingContext2D;
  ctx.fillStyle = colour("--ground");
  ctx.fillRect(0, 0, made.width, made.height);
  canvases.forEach((one, k) => ctx.drawImage(one, at[k]?.[0] ?? 0, at[k]?.[1] ?? 0));
  ctx.fillStyle = colour("--text");
  ctx.font = font;
  lines.forEach((line, k) => ctx.fillText(line, kMargin * scale, height + (kMargin + k * kLine) * scale));
  return made;
}

/** Lines no wider than may be. */
export function wrapped(text: string, most: number, widthOf: (text: string) => number): string[] {
  const lines: string[] = [];
  for (const word of text.split(/\s+/).filter(Boolean)) {
    const last = lines.at(-1);
    if (last !== undefined && widthOf(`${last} ${word}`) <= most) lines[lines.length - 1] = `${last} ${word}`;
    else lines.push(word);
  }
  return lines;
}

/** As the browser saves what it is given. */
export function save(content: Blob, name: string): void {
  const address = URL.createObjectURL(content);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
