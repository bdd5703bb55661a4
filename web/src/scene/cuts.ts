// Long straight parts are drawn broken, as in a technical drawing: a piece of them is left out, and said.

import type { SceneData, Shape } from "../lib/types.ts";

/** What is left out along an axis: between `low` and `high` only `kept` is drawn [m]. */
export interface Cut {
  axis: 0 | 1 | 2;
  low: number;
  high: number;
  kept: number;
}

type Range = [low: number, high: number];

/** Lines that may be broken; of a coil every turn is seen, and what is wide is not drawn shorter. */
const LINES = ["wire", "tether", "ground", "link", "phalanx", "fingertip"];
/** A part of a line is straight along an axis if it leaves it by less than this share. */
const STRAIGHT = 0.02;
/** How long the picture should be, as often as it is wide: by axis. */
const WANTED: [number, number, number] = [2.6, 2.6, 0.9];
/** Share of the rest that gaps keep at least, by axis; and what must be won for a cut. */
const LEAST: [number, number, number] = [0.3, 0.3, 0.1];
const WORTH = 0.2;
/** Pictures of a run that are looked at. */
const LOOKS = 25;

/** Coordinates of all points of all shapes at some pictures [m]: by shape, by picture. */
function placesOf(data: SceneData): number[][][] {
  const step = Math.max(1, Math.ceil(data.frames.length / LOOKS));
  const chosen = data.frames.filter((_, k) => k % step === 0 || k === data.frames.length - 1);
  let from = 0;
  return data.shapes.map((shape) => {
    const all = (numbers: number[]): number[] => numbers.map((x) => x * data.quantum);
    if (shape.still) return [all(shape.still)];
    const begin = from;
    from += 3 * shape.count;
    return chosen.map((frame) => all(frame.slice(begin, begin + 3 * shape.count)));
  });
}

const mayBreak = (shape: Shape): boolean => LINES.includes(shape.kind) && !shape.coil;

/** What a shape takes up of an axis, so that it cannot be cut there. */
function taken(shape: Shape, pictures: number[][], axis: 0 | 1 | 2): Range[] {
  const found: Range[] = [];
  const others = [0, 1, 2].filter((k) => k !== axis);
  const at = (picture: number[], point: number, k: number): number => picture[3 * point + k] ?? 0;
  for (const picture of pictures) {
    for (let point = 0; point < shape.count; point++) {
      const x = at(picture, point, axis);
      const around = (mayBreak(shape) ? 0.2 : 1.2) * shape.size;
      found.push([x - around, x + around]);
      if (point === 0) continue;
      const before = at(picture, point - 1, axis);
      const aside = Math.max(...others.map((k) => Math.abs(at(picture, point, k) - at(picture, point - 1, k))));
      const straight = mayBreak(shape) && aside <= STRAIGHT * Math.abs(x - before);
      if (!straight) found.push([Math.min(x, before), Math.max(x, before)]);
    }
  }
  return found;
}

/** Ranges that nothing takes up, between those that something does. */
function gapsOf(ranges: Range[]): { gaps: Range[]; ends: Range } {
  const sorted = [...ranges].sort((a, b) => a[0] - b[0]);
  const gaps: Range[] = [];
  let reached = sorted[0]?.[1] ?? 0;
  for (const [low, high] of sorted) {
    if (low > reached) gaps.push([reached, low]);
    reached = Math.max(reached, high);
  }
  return { gaps, ends: [sorted[0]?.[0] ?? 0, reached] };
}

const known = new WeakMap<SceneData, Cut[]>();

/** Where pictures of these runs are best broken; of one run it is found once. */
export function findCuts(runs: SceneData[]): Cut[] {
  const [only, other] = runs;
  if (!only || other) return seekCuts(runs);
  const cuts = known.get(only) ?? seekCuts(runs);
  known.set(only, cuts);
  return cuts;
}

function seekCuts(runs: SceneData[]): Cut[] {
  const shapes = runs.flatMap((data) => placesOf(data).map((pictures, k) => ({ shape: data.shapes[k] as Shape, pictures })));
  if (!shapes.length) return [];
  const axes = ([0, 1, 2] as const).map((axis) => gapsOf(shapes.flatMap(({ shape, pictures }) => taken(shape, pictures, axis))));
  const sizes = axes.map(({ ends }) => ends[1] - ends[0]);
  return ([0, 2] as const).flatMap((axis) => {
    const size = sizes[axis] ?? 0;
    const wide = Math.max(...sizes.filter((_, k) => k !== axis));
    const gaps = (axes[axis]?.gaps ?? []).filter(([low, high]) => high - low > 0.12 * size);
    const open = gaps.reduce((sum, [low, high]) => sum + high - low, 0);
    const rest = size - open;
    const share = Math.max((Math.max(WANTED[axis] * wide, rest) - rest) / (open || 1), (LEAST[axis] * rest) / (open || 1));
    if (share >= 1 || (1 - share) * open < WORTH * size) return [];
    return gaps.map(([low, high]): Cut => {
      const margin = 0.5 * share * (high - low);
      return { axis, low: low + 0.5 * margin, high: high - 0.5 * margin, kept: margin };
    });
  });
}

/** Where a coordinate is drawn. The side of a cut on which zero is stays in place. */
export function drawnAt(cuts: Cut[], axis: number, x: number): number {
  let moved = x;
  for (const cut of cuts) {
    if (cut.axis !== axis) continue;
    const lost = cut.high - cut.low - cut.kept;
    const share = Math.min(Math.max((x - cut.low) / (cut.high - cut.low), 0), 1);
    moved += cut.high <= 0 || Math.abs(cut.high) < Math.abs(cut.low) ? (1 - share) * lost : -share * lost;
  }
  return moved;
}

/** How much of its length a cut leaves out [m]. */
export const lengthOf = (cut: Cut): number => cut.high - cut.low - cut.kept;
