// What a chart shows, in shown units; drawn onto the canvas of uPlot between its axes.

import type uPlot from "uplot";
import type { Palette } from "../lib/theme.ts";
import { faint, type Look } from "./palette.ts";

export type Numbers = ArrayLike<number>;

export interface Curve {
  x: Numbers;
  y: Numbers;
  look: Look;
  /** First and last point; all if left out. */
  part?: [first: number, last: number];
  /** With arrowheads along the way. */
  arrows?: boolean;
}

/** Shaded from x to x, with a word where there is room. */
export interface Shade {
  begin: number;
  end: number;
  strong: boolean;
  word: string;
}

/** A level across the chart. */
export interface Level {
  y: number;
  word: string;
}

/** A filled strip between two lines, each with its name. */
export interface Strip {
  colour: number;
  sides: { x: number[]; y: number[]; name: string; dash: number[] }[];
}

/** A point that moves along a curve with the time cursor. */
export interface Mark {
  x: Numbers;
  y: Numbers;
  colour: number;
}

export interface Picture {
  xLabel: string;
  yLabel: string;
  xLimits: [number, number];
  yLimits: [number, number];
  curves: Curve[];
  shades?: Shade[];
  levels?: Level[];
  strips?: Strip[];
  marks?: Mark[];
}

/** Limits around all values, wide enough for a constant to look like one. */
export function around(columns: Numbers[], includes: readonly number[] = [], room = 0.07): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const column of [...columns, includes]) {
    for (let i = 0; i < column.length; i++) {
      const value = column[i] as number;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low <= high)) return [0, 1];
  const size = Math.max(Math.abs(low), Math.abs(high));
  const wide = high - low;
  const extra = wide <= 1e-6 * size || wide === 0 ? 0.1 * size || 1 : room * wide;
  return [low - extra, high + extra];
}

/** Canvas coordinates of a value. */
interface Way {
  (value: number): number;
}

function scaled(u: uPlot, key: "x" | "y"): Way {
  const scale = u.scales[key];
  const low = scale?.min ?? 0;
  const high = scale?.max ?? 1;
  const { left, top, width, height } = u.bbox;
  const across = width / (high - low);
  const up = height / (high - low);
  return key === "x" ? (v) => left + (v - low) * across : (v) => top + height - (v - low) * up;
}

function inside(u: uPlot, draw: () => void): void {
  const { left, top, width, height } = u.bbox;
  u.ctx.save();
  u.ctx.beginPath();
  u.ctx.rect(left, top, width, height);
  u.ctx.clip();
  draw();
  u.ctx.restore();
}

/** Ratio of pixels of the canvas to those of the page. */
const fine = (u: uPlot): number => u.ctx.canvas.width / u.width;

/** What lies below the grid: shades and strips. */
export function drawBelow(u: uPlot, picture: Picture, colours: Palette): void {
  const { ctx } = u;
  const x = scaled(u, "x");
  const y = scaled(u, "y");
  inside(u, () => {
    for (const shade of picture.shades ?? []) {
      ctx.fillStyle = faint(colours.bad, shade.strong ? 0.2 : 0.08);
      const left = x(shade.begin);
      ctx.fillRect(left, u.bbox.top, Math.max(x(shade.end) - left, fine(u)), u.bbox.height);
    }
    for (const strip of picture.strips ?? []) {
      ctx.fillStyle = faint(colours.curves[strip.colour] ?? colours.ink, 0.13);
      ctx.beginPath();
      const [start, finish] = strip.sides;
      if (!start || !finish) continue;
      start.x.forEach((v, i) => ctx.lineTo(x(v), y(start.y[i] ?? 0)));
      for (let i = finish.x.length - 1; i >= 0; i--) ctx.lineTo(x(finish.x[i] ?? 0), y(finish.y[i] ?? 0));
      ctx.fill();
    }
  });
}

/** Curves, levels, lines of strips, and names. */
export function drawAbove(u: uPlot, picture: Picture, colours: Palette): void {
  const { ctx } = u;
  const x = scaled(u, "x");
  const y = scaled(u, "y");
  const ratio = fine(u);
  const stroke = (look: Look): void => {
    ctx.strokeStyle = colours.curves[look.colour] ?? colours.ink;
    ctx.lineWidth = look.width * ratio;
    ctx.setLineDash(look.dash.map((d) => d * ratio));
    ctx.stroke();
  };
  inside(u, () => {
    ctx.lineJoin = "round";
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    const taken: [number, number][] = [];
    for (const strip of picture.strips ?? []) {
      for (const side of strip.sides) {
        ctx.beginPath();
        side.x.forEach((v, i) => ctx.lineTo(x(v), y(side.y[i] ?? 0)));
        stroke({ colour: strip.colour, dash: side.dash, width: 1 });
        nameLine(u, side, x, y, colours.curves[strip.colour] ?? colours.ink, ratio, taken);
      }
    }
    for (const level of picture.levels ?? []) drawLevel(u, level, y, colours, ratio);
    for (const curve of picture.curves) {
      const [first, last] = curve.part ?? [0, curve.x.length - 1];
      ctx.beginPath();
      let pen = false;
      for (let i = first; i <= last; i++) {
        const px = x(curve.x[i] as number);
        const py = y(curve.y[i] as number);
        if (Number.isFinite(px + py)) {
          if (pen) ctx.lineTo(px, py);
          else ctx.moveTo(px, py);
          pen = true;
        } else pen = false;
      }
      stroke(curve.look);
      if (curve.arrows) drawArrows(u, curve, first, last, x, y, ratio);
    }
    ctx.setLineDash([]);
    for (const shade of picture.shades ?? []) {
      const left = x(shade.begin);
      if (!shade.strong || !shade.word || x(shade.end) - left < 40 * ratio) continue;
      ctx.fillStyle = colours.bad;
      ctx.font = `${10 * ratio}px system-ui, sans-serif`;
      ctx.fillText(shade.word, Math.max(left, u.bbox.left) + 3 * ratio, u.bbox.top + 11 * ratio);
    }
  });
}

function drawLevel(u: uPlot, level: Level, y: Way, colours: Palette, ratio: number): void {
  const { ctx } = u;
  ctx.beginPath();
  ctx.moveTo(u.bbox.left, y(level.y));
  ctx.lineTo(u.bbox.left + u.bbox.width, y(level.y));
  ctx.strokeStyle = colours.bad;
  ctx.lineWidth = ratio;
  ctx.setLineDash([3 * ratio, 3 * ratio]);
  ctx.stroke();
  ctx.fillStyle = colours.bad;
  ctx.font = `${10 * ratio}px system-ui, sans-serif`;
  const wide = ctx.measureText(level.word).width;
  ctx.fillText(level.word, u.bbox.left + u.bbox.width - wide - 4 * ratio, y(level.y) - 3 * ratio);
}

const ARROW = 7;

/** Arrowheads at two places of a part that is long enough, as the eye measures length. */
function drawArrows(u: uPlot, curve: Curve, first: number, last: number, x: Way, y: Way, ratio: number): void {
  const way: number[] = [0];
  for (let i = first + 1; i <= last; i++) {
    const dx = x(curve.x[i] as number) - x(curve.x[i - 1] as number);
    const dy = y(curve.y[i] as number) - y(curve.y[i - 1] as number);
    const step = Math.hypot(dx, dy);
    way.push((way.at(-1) ?? 0) + (Number.isFinite(step) ? step : 0));
  }
  const long = way.at(-1) ?? 0;
  if (long < 60 * ratio) return;
  const at = (share: number): [number, number] => {
    const k = Math.max(1, way.findIndex((w) => w >= share * long));
    const a = way[k - 1] ?? 0;
    const t = ((share * long - a) / ((way[k] ?? 1) - a || 1)) || 0;
    const [i, j] = [first + k - 1, first + k];
    const px = x(curve.x[i] as number) * (1 - t) + x(curve.x[j] as number) * t;
    return [px, y(curve.y[i] as number) * (1 - t) + y(curve.y[j] as number) * t];
  };
  u.ctx.fillStyle = u.ctx.strokeStyle;
  u.ctx.setLineDash([]);
  const size = ARROW * ratio;
  for (const share of [0.3, 0.7]) {
    const [ax, ay] = at(share - Math.min(0.1, (0.7 * size) / long));
    const [bx, by] = at(share + Math.min(0.1, (0.7 * size) / long));
    const angle = Math.atan2(by - ay, bx - ax);
    u.ctx.save();
    u.ctx.translate((ax + bx) / 2, (ay + by) / 2);
    u.ctx.rotate(angle);
    u.ctx.beginPath();
    u.ctx.moveTo(size * 0.7, 0);
    u.ctx.lineTo(-size * 0.6, size * 0.55);
    u.ctx.lineTo(-size * 0.6, -size * 0.55);
    u.ctx.fill();
    u.ctx.restore();
  }
}

/** The name of a line of a strip, where it leaves the chart or ends. */
function nameLine(
  u: uPlot, side: Strip["sides"][number], x: Way, y: Way, colour: string, ratio: number,
  taken: [number, number][],
): void {
  const level = u.bbox.top + 14 * ratio;
  const flat = side.y.length > 1 && side.y[0] === side.y[1];
  let [px, py] = [x(side.x[0] ?? 0), y(side.y[0] ?? 0) - 4 * ratio];
  if (flat) px = Math.max(px, u.bbox.left) + 4 * ratio;
  else {
    for (let i = 1; i < side.x.length; i++) {
      const [ax, ay, bx, by] = [x(side.x[i - 1] ?? 0), y(side.y[i - 1] ?? 0), x(side.x[i] ?? 0), y(side.y[i] ?? 0)];
      const share = Math.min(1, (ay - level) / (ay - by || 1));
      [px, py] = [ax + share * (bx - ax) + 3 * ratio, Math.max(level, by + 10 * ratio)];
      if (by <= level) break;
    }
  }
  while (taken.some(([a, b]) => Math.abs(a - px) < 18 * ratio && Math.abs(b - py) < 12 * ratio)) py += 13 * ratio;
  taken.push([px, py]);
  const [head = "", index = ""] = side.name.split("_");
  const { ctx } = u;
  ctx.fillStyle = colour;
  ctx.font = `italic ${12 * ratio}px system-ui, sans-serif`;
  const letter = head === "sigma" ? "σ" : head;
  ctx.fillText(letter, px, py);
  const wide = ctx.measureText(letter).width;
  ctx.font = `italic ${9 * ratio}px system-ui, sans-serif`;
  ctx.fillText(index, px + wide, py + 3 * ratio);
}
