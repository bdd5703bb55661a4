// Drawing a picture of a sweep on a canvas: frame, cells or points, lines, and what is marked.

import type { Palette } from "../lib/theme.ts";
import { viridis } from "./colours.ts";
import { share, ticks, tickText, type Dim } from "./scale.ts";

export type State = "ok" | "failed" | "never" | "missing";

export interface Spot {
  row: number;
  x: number;
  y: number;
  /** Number that gives the colour; null for none. */
  value: number | null;
  state: State;
  /** Places among the levels, in a map. */
  ix?: number;
  iy?: number;
}

export interface Picture {
  x: Dim;
  y: Dim;
  spots: Spot[];
  /** Levels of a map; points are drawn without. */
  cells?: { xs: number[]; ys: number[] };
  colour?: Dim;
  /** Spots that a line joins. */
  path?: Spot[];
  /** Whether spots off the path are faint. */
  quiet?: boolean;
}

export interface Box {
  left: number;
  top: number;
  width: number;
  height: number;
}

const FONT = "12px system-ui, sans-serif";
export const MARGIN = { left: 64, right: 14, top: 10, bottom: 44 };

export const boxOf = (width: number, height: number): Box => ({
  left: MARGIN.left, top: MARGIN.top, width: Math.max(width - MARGIN.left - MARGIN.right, 10),
  height: Math.max(height - MARGIN.top - MARGIN.bottom, 10),
});

export const place = (picture: Picture, box: Box, spot: { x: number; y: number }): [number, number] => [
  box.left + share(picture.x, spot.x) * box.width,
  box.top + (1 - share(picture.y, spot.y)) * box.height,
];

/** Limits of the cells along one side, as shares: half-way between the levels. */
export function edges(dim: Dim, levels: number[]): number[] {
  const at = levels.map((level) => share(dim, level));
  const inner = at.slice(1).map((one, k) => (one + (at[k] ?? one)) / 2);
  return [0, ...inner, 1];
}

/** Ends of a scale of cells: half a cell beyond the outer levels. */
export function dimOfLevels(label: string, levels: number[], log: boolean): Dim {
  const [first = 0, second = first + 1] = levels;
  const [last = first, before = last - 1] = [levels.at(-1), levels.at(-2)];
  if (levels.length < 2) return { label, low: first - 0.5, high: first + 0.5 };
  if (log && first > 0) return { label, low: first / Math.sqrt(second / first), high: last * Math.sqrt(last / before), log };
  return { label, low: first - (second - first) / 2, high: last + (last - before) / 2 };
}

export function draw(canvas: HTMLCanvasElement, picture: Picture, marked: number[], theme: Palette): void {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const dense = devicePixelRatio || 1;
  canvas.width = Math.round(width * dense);
  canvas.height = Math.round(height * dense);
  const pen = canvas.getContext("2d");
  if (!pen) return;
  pen.scale(dense, dense);
  pen.font = FONT;
  const box = boxOf(width, height);
  frame(pen, picture, box, theme);
  pen.save();
  pen.beginPath();
  pen.rect(box.left - 5, box.top - 5, box.width + 10, box.height + 10);
  pen.clip();
  if (picture.cells) cells(pen, picture, box, theme);
  else points(pen, picture, box, theme);
  for (const spot of picture.spots) if (marked.includes(spot.row)) mark(pen, picture, box, theme, spot);
  pen.restore();
}

function frame(pen: CanvasRenderingContext2D, { x, y }: Picture, box: Box, theme: Palette): void {
  pen.strokeStyle = theme.line;
  pen.fillStyle = theme.ink;
  pen.lineWidth = 1;
  pen.strokeRect(box.left + 0.5, box.top + 0.5, box.width, box.height);
  pen.textAlign = "center";
  pen.textBaseline = "top";
  for (const tick of ticks(x, box.width / 80)) {
    const at = box.left + share(x, tick) * box.width;
    line(pen, at, box.top + box.height, at, box.top + box.height + 4);
    pen.fillText(tickText(tick), at, box.top + box.height + 6);
  }
  pen.fillText(x.label, box.left + box.width / 2, box.top + box.height + 25);
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const tick of ticks(y, box.height / 45)) {
    const at = box.top + (1 - share(y, tick)) * box.height;
    line(pen, box.left - 4, at, box.left, at);
    pen.fillText(tickText(tick), box.left - 7, at);
  }
  pen.save();
  pen.translate(12, box.top + box.height / 2);
  pen.rotate(-Math.PI / 2);
  pen.textAlign = "center";
  pen.fillText(y.label, 0, 0);
  pen.restore();
}

function line(pen: CanvasRenderingContext2D, x0: number, y0: number, x1: number, y1: number): void {
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}

/** A pattern: hatched for failed, dotted for never happened; so that it does not hang on a colour. */
function pattern(pen: CanvasRenderingContext2D, state: State, theme: Palette): CanvasPattern | string {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 8;
  const small = tile.getContext("2d");
  if (!small) return theme.line;
  small.fillStyle = theme.panel;
  small.fillRect(0, 0, 8, 8);
  small.fillStyle = small.strokeStyle = state === "failed" ? theme.bad : theme.soft;
  small.lineWidth = 1.5;
  if (state === "failed") [-8, 0, 8].forEach((k) => line(small, k, 8, k + 8, 0));
  else small.fillRect(3, 3, 2, 2);
  return pen.createPattern(tile, "repeat") ?? theme.line;
}

export function cellOf(picture: Picture, box: Box, spot: Spot): Box {
  const xs = edges(picture.x, picture.cells?.xs ?? []);
  const ys = edges(picture.y, picture.cells?.ys ?? []);
  return cellAt(xs, ys, box, spot);
}

function cellAt(xs: number[], ys: number[], box: Box, { ix = 0, iy = 0 }: Spot): Box {
  const [x0 = 0, x1 = 1, y0 = 0, y1 = 1] = [xs[ix], xs[ix + 1], ys[iy], ys[iy + 1]];
  return {
    left: box.left + x0 * box.width, width: (x1 - x0) * box.width,
    top: box.top + (1 - y1) * box.height, height: (y1 - y0) * box.height,
  };
}

function cells(pen: CanvasRenderingContext2D, picture: Picture, box: Box, theme: Palette): void {
  const looks: Partial<Record<State, CanvasPattern | string>> = {
    failed: pattern(pen, "failed", theme), never: pattern(pen, "never", theme), ok: theme.panel,
  };
  const xs = edges(picture.x, picture.cells?.xs ?? []);
  const ys = edges(picture.y, picture.cells?.ys ?? []);
  for (const spot of picture.spots) {
    if (spot.state === "missing") continue;
    const cell = cellAt(xs, ys, box, spot);
    const seen = spot.value !== null && picture.colour;
    pen.fillStyle = seen ? viridis(share(seen, spot.value ?? 0)) : (looks[spot.state] ?? theme.panel);
    pen.fillRect(cell.left, cell.top, cell.width + 0.6, cell.height + 0.6);
  }
}

function points(pen: CanvasRenderingContext2D, picture: Picture, box: Box, theme: Palette): void {
  const { spots, path, quiet, colour } = picture;
  const size = spots.length > 3000 ? 2 : 3.5;
  for (const spot of spots) {
    const [x, y] = place(picture, box, spot);
    if (spot.state === "failed") {
      pen.strokeStyle = theme.bad;
      pen.lineWidth = 1.5;
      line(pen, x - 3, y - 3, x + 3, y + 3);
      line(pen, x - 3, y + 3, x + 3, y - 3);
      continue;
    }
    if (spot.state !== "ok") continue;
    pen.globalAlpha = quiet ? 0.45 : 1;
    pen.fillStyle = colour && spot.value !== null ? viridis(share(colour, spot.value)) : quiet ? theme.soft : theme.accent;
    pen.beginPath();
    pen.arc(x, y, size, 0, 7);
    pen.fill();
    pen.globalAlpha = 1;
  }
  if (!path?.length) return;
  pen.strokeStyle = pen.fillStyle = theme.accent;
  pen.lineWidth = 2;
  pen.beginPath();
  for (const spot of path) pen.lineTo(...place(picture, box, spot));
  pen.stroke();
  if (quiet) for (const spot of path) dot(pen, ...place(picture, box, spot), 4);
}

function dot(pen: CanvasRenderingContext2D, x: number, y: number, size: number): void {
  pen.beginPath();
  pen.arc(x, y, size, 0, 7);
  pen.fill();
}

/** A double line around a spot, which is seen on any colour. */
function mark(pen: CanvasRenderingContext2D, picture: Picture, box: Box, theme: Palette, spot: Spot): void {
  const cell = cellOf(picture, box, spot);
  const [x, y] = place(picture, box, spot);
  for (const [colour, width] of [[theme.panel, 5], [theme.ink, 2]] as const) {
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    if (picture.cells) pen.rect(cell.left, cell.top, cell.width, cell.height);
    else pen.arc(x, y, 7, 0, 7);
    pen.stroke();
  }
}
