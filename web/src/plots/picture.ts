// What a chart shows, in shown units.

import type { Look } from "./palette.ts";
import { share, type Numbers, type Scale } from "./scale.ts";

export type { Numbers, Scale };

export interface Curve {
  x: Numbers;
  y: Numbers;
  look: Look;
  /** What it is called where its values are told. */
  name?: string;
  /** Points instead of a line. */
  dots?: "full" | "ring";
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
  /** A part that is chosen, no alarm. */
  calm?: boolean;
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

export type State = "ok" | "failed" | "never" | "missing";

/** One of many: a point of a scatter, or a cell of a map. */
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
  x: Scale;
  y: Scale;
  curves: Curve[];
  /** Whether the curves are told by their x, as over time. */
  along?: boolean;
  shades?: Shade[];
  levels?: Level[];
  strips?: Strip[];
  marks?: Mark[];
  spots?: Spot[];
  /** Levels of a map; spots are points without. */
  cells?: { xs: number[]; ys: number[] };
  /** What the colour of spots means. */
  colour?: Scale;
  /** Whether spots are faint. */
  quiet?: boolean;
  /** Spots with a ring around them. */
  rings?: Spot[];
}

export interface Box {
  left: number;
  top: number;
  width: number;
  height: number;
}

/** Room for numbers and labels at the four sides, and for the bar of colours at the right [px]. */
const SIDES = { left: 60, right: 10, top: 6, bottom: 42, bare: 6, bar: 74 };

/** Where the curves are, on a chart of such a size. */
export const boxOf = (picture: Picture, width: number, height: number, bare = false): Box => ({
  left: SIDES.left, top: SIDES.top,
  width: Math.max(width - SIDES.left - SIDES.right - (picture.colour ? SIDES.bar : 0), 10),
  height: Math.max(height - SIDES.top - (bare ? SIDES.bare : SIDES.bottom), 10),
});

/** Limits of the cells along one side, as shares of what is shown: half-way between the levels. */
export function edges(scale: Scale, levels: number[]): number[] {
  const at = levels.map((level) => share(scale, level));
  const half = (a = 0.5, b = a): number => a + (b - a) / 2;
  if (at.length < 2) return [0, 1];
  const inner = at.slice(1).map((one, k) => half(at[k], one));
  const [first = 0, second, last = 1, before] = [at[0], at[1], at.at(-1), at.at(-2)];
  return [2 * first - half(first, second), ...inner, 2 * last - half(last, before)];
}

/** Ends of a scale of cells: half a cell beyond the outer levels. */
export function scaleOfLevels(label: string, levels: number[], log: boolean): Scale {
  const [first = 0, second = first + 1] = levels;
  const [last = first, before = last - 1] = [levels.at(-1), levels.at(-2)];
  if (levels.length < 2) return { label, low: first - 0.5, high: first + 0.5 };
  if (log && first > 0) return { label, low: first / Math.sqrt(second / first), high: last * Math.sqrt(last / before), log };
  return { label, low: first - (second - first) / 2, high: last + (last - before) / 2 };
}
