// Drawing a picture with a pen: that of a canvas, or one that writes SVG.

import type { Palette } from "../lib/theme.ts";
import { viridis } from "./colours.ts";
import type { Look } from "./palette.ts";
import { boxOf, edges, type Box, type Curve, type Level, type Picture, type Spot, type State } from "./picture.ts";
import { share, ticks, tickText } from "./scale.ts";
import { drawSides } from "./strips.ts";

export type Pen = Pick<
  CanvasRenderingContext2D,
  | "save" | "restore" | "beginPath" | "moveTo" | "lineTo" | "arc" | "rect" | "clip" | "fill" | "stroke" | "fillRect" | "fillText"
  | "measureText" | "translate" | "rotate" | "setLineDash" | "fillStyle" | "strokeStyle" | "lineWidth" | "lineJoin" | "font"
  | "textAlign" | "textBaseline" | "globalAlpha"
>;

/** What a part is drawn with: pixels of a value across and up. */
export interface Sheet {
  pen: Pen;
  box: Box;
  colours: Palette;
  x: (value: number) => number;
  y: (value: number) => number;
}

export const FAMILY = "system-ui, sans-serif";
const WORD = `10px ${FAMILY}`;

/** Draw a picture of such a size; `bare`: another chart below has the numbers of x. */
export function drawPicture(pen: Pen, picture: Picture, width: number, height: number, colours: Palette, bare = false): void {
  const box = boxOf(picture, width, height, bare);
  const sheet: Sheet = {
    pen, box, colours,
    x: (value) => box.left + share(picture.x, value) * box.width,
    y: (value) => box.top + (1 - share(picture.y, value)) * box.height,
  };
  pen.lineJoin = "round";
  clipped(sheet, () => drawShades(sheet, picture));
  drawFrame(sheet, picture, bare);
  clipped(sheet, () => {
    if (picture.cells) drawCells(sheet, picture);
    else drawSpots(sheet, picture);
    const taken: [number, number][] = [];
    for (const strip of picture.strips ?? []) drawSides(sheet, strip, taken);
    for (const level of picture.levels ?? []) drawLevel(sheet, level);
    for (const curve of picture.curves) drawCurve(sheet, curve);
    for (const spot of picture.rings ?? []) ringSpot(sheet, picture, spot);
    drawWords(sheet, picture);
  });
  if (picture.colour) drawBar(sheet, picture.colour);
}

function clipped({ pen, box }: Sheet, draw: () => void): void {
  pen.save();
  pen.beginPath();
  pen.rect(box.left, box.top, box.width, box.height);
  pen.clip();
  draw();
  pen.restore();
}

function drawLine(pen: Pen, x0: number, y0: number, x1: number, y1: number): void {
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
}

/** Printed numbers have a minus, not a hyphen. */
const minus = (text: string): string => text.replaceAll("-", "\u2212");

/** Least distance of numbers across and up [px]. */
const APART = { x: 62, y: 20 };

function drawFrame({ pen, box, colours, x, y }: Sheet, picture: Picture, bare: boolean): void {
  const [right, bottom] = [box.left + box.width, box.top + box.height];
  const across = ticks(picture.x, box.width / APART.x);
  const up = ticks(picture.y, box.height / APART.y);
  pen.strokeStyle = colours.line;
  pen.lineWidth = 1;
  pen.beginPath();
  for (const tick of across) drawLine(pen, Math.round(x(tick)) + 0.5, box.top, Math.round(x(tick)) + 0.5, bottom + (bare ? 0 : 4));
  for (const tick of up) drawLine(pen, box.left - 4, Math.round(y(tick)) + 0.5, right, Math.round(y(tick)) + 0.5);
  pen.stroke();
  pen.fillStyle = colours.soft;
  pen.font = `11.5px ${FAMILY}`;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  const apart = (all: number[]): number => Math.abs((all[1] ?? 0) - (all[0] ?? 0));
  for (const tick of up) pen.fillText(minus(tickText(tick, apart(up))), box.left - 8, y(tick));
  pen.textAlign = "center";
  if (!bare) {
    pen.textBaseline = "top";
    for (const tick of across) pen.fillText(minus(tickText(tick, apart(across))), x(tick), bottom + 7);
    pen.font = `12px ${FAMILY}`;
    pen.fillText(picture.x.label, box.left + box.width / 2, bottom + 23);
  }
  writeUpward(pen, picture.y.label, 7, box.top + box.height / 2);
}

function writeUpward(pen: Pen, words: string, x: number, y: number): void {
  pen.font = `12px ${FAMILY}`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.save();
  pen.translate(x, y);
  pen.rotate(-Math.PI / 2);
  pen.fillText(words, 0, 0);
  pen.restore();
}

/** Thickness of the bar of colours, its distance from the chart, and how many steps it is drawn in. */
const BAR = { wide: 14, apart: 12, steps: 64 };

function drawBar({ pen, box, colours }: Sheet, scale: NonNullable<Picture["colour"]>): void {
  const left = box.left + box.width + BAR.apart;
  const piece = box.height / BAR.steps;
  for (let k = 0; k < BAR.steps; k++) {
    pen.fillStyle = viridis((k + 0.5) / BAR.steps);
    pen.fillRect(left, box.top + box.height - (k + 1) * piece, BAR.wide, piece + 0.6);
  }
  pen.fillStyle = colours.soft;
  pen.font = `11.5px ${FAMILY}`;
  pen.textAlign = "left";
  pen.textBaseline = "middle";
  for (const tick of ticks(scale, 5)) pen.fillText(minus(tickText(tick)), left + BAR.wide + 4, box.top + (1 - share(scale, tick)) * box.height);
  writeUpward(pen, scale.label, left + BAR.wide + 50, box.top + box.height / 2);
}

/** The same colour, seen through. */
function faint(colour: string, alpha: number): string {
  const [r = "0", g = "0", b = "0"] = colour.match(/[\d.]+/g) ?? [];
  return `rgba(${r}, ${g}, ${b}, ${alpha})`;
}

/** What lies below the grid: shades and strips. */
function drawShades({ pen, box, colours, x, y }: Sheet, { shades = [], strips = [] }: Picture): void {
  for (const { begin, end, strong, calm } of shades) {
    pen.fillStyle = faint(calm ? colours.accent : colours.bad, strong ? 0.2 : calm ? 0.1 : 0.08);
    const [left, right] = [Math.max(x(begin), box.left - 2), Math.min(x(end), box.left + box.width + 2)];
    if (right < left) continue;
    pen.fillRect(left, box.top, Math.max(right - left, 1), box.height);
    if (!calm) continue;
    pen.fillStyle = colours.accent;
    for (const edge of [left, right]) pen.fillRect(edge - 0.5, box.top, 1, box.height);
  }
  for (const strip of strips) {
    const [start, finish] = strip.sides;
    if (!start || !finish) continue;
    pen.fillStyle = faint(colours.curves[strip.colour] ?? colours.ink, 0.13);
    pen.beginPath();
    start.x.forEach((v, i) => pen.lineTo(x(v), y(start.y[i] ?? 0)));
    for (let i = finish.x.length - 1; i >= 0; i--) pen.lineTo(x(finish.x[i] ?? 0), y(finish.y[i] ?? 0));
    pen.fill();
  }
}

export function setStroke({ pen, colours }: Sheet, look: Look): void {
  pen.strokeStyle = colours.curves[look.colour] ?? colours.ink;
  pen.lineWidth = look.width;
  pen.setLineDash(look.dash);
}

/** What is nearer than this to what was drawn last is not seen [px]. */
const HAIR = 0.35;

function drawCurve(sheet: Sheet, curve: Curve): void {
  const { pen, x, y, colours } = sheet;
  const [first, last] = curve.part ?? [0, Math.min(curve.x.length, curve.y.length) - 1];
  setStroke(sheet, curve.look);
  if (curve.dots) {
    pen.setLineDash([]);
    pen.lineWidth = 1.5;
    pen.fillStyle = curve.dots === "ring" ? colours.panel : pen.strokeStyle;
  }
  pen.beginPath();
  let down = false;
  let [fromX, fromY] = [0, 0];
  for (let i = first; i <= last; i++) {
    const px = x(curve.x[i] as number);
    const py = y(curve.y[i] as number);
    if (!Number.isFinite(px + py)) down = false;
    else if (down && i < last && Math.abs(px - fromX) < HAIR && Math.abs(py - fromY) < HAIR) continue;
    else if (curve.dots) {
      pen.moveTo(px + 2.2, py);
      pen.arc(px, py, 2.2, 0, 7);
    } else {
      if (down) pen.lineTo(px, py);
      else pen.moveTo(px, py);
      down = true;
    }
    [fromX, fromY] = [px, py];
  }
  if (curve.dots) pen.fill();
  if (curve.dots !== "full") pen.stroke();
  pen.setLineDash([]);
  if (curve.arrows) drawArrows(sheet, curve, first, last);
}

function drawLevel({ pen, box, colours, y }: Sheet, level: Level): void {
  const [right, at] = [box.left + box.width, y(level.y)];
  pen.strokeStyle = pen.fillStyle = colours.bad;
  pen.lineWidth = 1;
  pen.setLineDash([3, 3]);
  pen.beginPath();
  drawLine(pen, box.left, at, right, at);
  pen.stroke();
  pen.setLineDash([]);
  pen.font = WORD;
  pen.textAlign = "right";
  pen.textBaseline = "alphabetic";
  pen.fillText(level.word, right - 4, at - 3);
}

function drawWords({ pen, box, colours, x }: Sheet, { shades = [] }: Picture): void {
  pen.fillStyle = colours.bad;
  pen.font = WORD;
  pen.textAlign = "left";
  pen.textBaseline = "alphabetic";
  for (const { begin, end, strong, word } of shades) {
    if (strong && word && x(end) - x(begin) >= 40) pen.fillText(word, Math.max(x(begin), box.left) + 3, box.top + 11);
  }
}

const [ARROW, SHORT] = [7, 60];

/** Arrowheads at two places of a part that is long enough, as the eye measures length. */
function drawArrows({ pen, x, y }: Sheet, curve: Curve, first: number, last: number): void {
  const point = (i: number): [number, number] => [x(curve.x[i] as number), y(curve.y[i] as number)];
  const way = new Float64Array(last - first + 1);
  for (let i = first + 1, [ax, ay] = point(first); i <= last; i++) {
    const [bx, by] = point(i);
    const step = Math.sqrt((bx - ax) ** 2 + (by - ay) ** 2);
    way[i - first] = way[i - first - 1]! + (Number.isFinite(step) ? step : 0);
    [ax, ay] = [bx, by];
  }
  const long = way[last - first] ?? 0;
  if (long < SHORT) return;
  const at = (part: number): [number, number] => {
    const k = Math.max(1, way.findIndex((w) => w >= part * long));
    const a = way[k - 1] ?? 0;
    const t = (part * long - a) / ((way[k] ?? 1) - a || 1) || 0;
    const [[ax, ay], [bx, by]] = [point(first + k - 1), point(first + k)];
    return [ax + t * (bx - ax), ay + t * (by - ay)];
  };
  pen.fillStyle = pen.strokeStyle;
  const half = Math.min(0.1, (0.7 * ARROW) / long);
  for (const part of [0.3, 0.7]) {
    const [[ax, ay], [bx, by]] = [at(part - half), at(part + half)];
    const far = Math.hypot(bx - ax, by - ay) || 1;
    const [ux, uy] = [((bx - ax) / far) * ARROW, ((by - ay) / far) * ARROW];
    const [mx, my] = [(ax + bx) / 2, (ay + by) / 2];
    pen.beginPath();
    pen.moveTo(mx + 0.7 * ux, my + 0.7 * uy);
    pen.lineTo(mx - 0.6 * ux - 0.55 * uy, my - 0.6 * uy + 0.55 * ux);
    pen.lineTo(mx - 0.6 * ux + 0.55 * uy, my - 0.6 * uy - 0.55 * ux);
    pen.fill();
  }
}

/** Where the cell of a spot is, given the limits of cells as shares. */
function cellAt(xs: number[], ys: number[], box: Box, { ix = 0, iy = 0 }: Spot): [number, number, number, number] {
  const [x0 = 0, x1 = 1, y0 = 0, y1 = 1] = [xs[ix], xs[ix + 1], ys[iy], ys[iy + 1]];
  return [box.left + x0 * box.width, box.top + (1 - y1) * box.height, (x1 - x0) * box.width, (y1 - y0) * box.height];
}

/** Cells of a map; hatched for failed, dotted for never happened, so that it does not hang on a colour. */
function drawCells(sheet: Sheet, picture: Picture): void {
  const { pen, box, colours } = sheet;
  const [xs, ys] = [edges(picture.x, picture.cells?.xs ?? []), edges(picture.y, picture.cells?.ys ?? [])];
  const without: Record<State, Spot[]> = { ok: [], failed: [], never: [], missing: [] };
  for (const spot of picture.spots ?? []) {
    if (spot.value === null || !picture.colour) {
      without[spot.state].push(spot);
      continue;
    }
    const [left, top, width, height] = cellAt(xs, ys, box, spot);
    pen.fillStyle = viridis(share(picture.colour, spot.value));
    pen.fillRect(left, top, width + 0.6, height + 0.6);
  }
  for (const state of ["failed", "never", "ok"] as const) {
    if (!without[state].length) continue;
    pen.save();
    pen.beginPath();
    for (const spot of without[state]) pen.rect(...cellAt(xs, ys, box, spot));
    pen.fillStyle = colours.panel;
    pen.fill();
    pen.clip();
    drawPattern(sheet, state);
    pen.restore();
  }
}

function drawPattern({ pen, box, colours }: Sheet, state: State): void {
  const tile = 8;
  pen.beginPath();
  if (state === "failed") {
    for (let k = -box.height; k < box.width; k += tile) drawLine(pen, box.left + k, box.top + box.height, box.left + k + box.height, box.top);
    pen.strokeStyle = colours.bad;
    pen.lineWidth = 1.5;
    pen.stroke();
  } else if (state === "never") {
    for (let i = 3; i < box.width; i += tile) for (let k = 3; k < box.height; k += tile) pen.rect(box.left + i, box.top + k, 2, 2);
    pen.fillStyle = colours.soft;
    pen.fill();
  }
}

/** More spots than these are small. */
const MANY = 3000;

function drawSpots({ pen, colours, x, y }: Sheet, { spots = [], quiet, colour }: Picture): void {
  const size = spots.length > MANY ? 2 : 3.5;
  for (const spot of spots) {
    const [px, py] = [x(spot.x), y(spot.y)];
    pen.beginPath();
    if (spot.state === "failed") {
      drawLine(pen, px - 3, py - 3, px + 3, py + 3);
      drawLine(pen, px - 3, py + 3, px + 3, py - 3);
      pen.strokeStyle = colours.bad;
      pen.lineWidth = 1.5;
      pen.stroke();
    } else if (spot.state === "ok") {
      pen.globalAlpha = quiet ? 0.45 : 1;
      pen.fillStyle = colour && spot.value !== null ? viridis(share(colour, spot.value)) : quiet ? colours.soft : colours.accent;
      pen.arc(px, py, size, 0, 7);
      pen.fill();
      pen.globalAlpha = 1;
    }
  }
}

/** A double line around a spot, which is seen on any colour. */
function ringSpot({ pen, box, colours, x, y }: Sheet, picture: Picture, spot: Spot): void {
  const { cells } = picture;
  pen.beginPath();
  if (cells) pen.rect(...cellAt(edges(picture.x, cells.xs), edges(picture.y, cells.ys), box, spot));
  else pen.arc(x(spot.x), y(spot.y), 7, 0, 7);
  for (const [colour, width] of [[colours.panel, 5], [colours.ink, 2]] as const) {
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.stroke();
  }
}
