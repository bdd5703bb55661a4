// Runs as spots of a picture.

import { liveLook } from "../plots/palette.ts";
import { scaleOfLevels, type Picture, type Spot, type State } from "../plots/picture.ts";
import { around, type Scale } from "../plots/scale.ts";
import type { Runs } from "./shown.ts";
import type { Axis, Column } from "./types.ts";

/** Statuses from here on are failures. */
const FAILED = 2;

export const titled = (one: Column): string => (one.display_unit ? `${one.short} [${one.display_unit}]` : one.short);
const isNumber = (value: number | null): value is number => value !== null;

function stateOf(runs: Runs, at: number, value: number | null): State {
  if ((runs.status[at] ?? 0) >= FAILED) return "failed";
  return value === null ? "never" : "ok";
}

/** Scale of the colour; none without numbers. */
function colourOf(label: string, spots: Spot[]): { colour?: Scale } {
  const known = spots.map((spot) => spot.value).filter(isNumber);
  return known.length ? { colour: around(label, [known], 0) } : {};
}

const shownLevels = (axis: Axis, stride: number): { place: number; value: number }[] =>
  (axis.levels ?? [])
    .map((level, place) => ({ place, value: level * axis.factor + axis.offset }))
    .filter(({ place }) => place % stride === 0);

/** A map over two axes of a grid, the others at given levels. */
export function mapOf(runs: Runs, x: number, y: number, fixed: number[], measure: Column): Picture {
  const { axes, strides } = runs.layout;
  const [along, up] = [axes[x], axes[y]] as [Axis, Axis];
  const xs = shownLevels(along, strides[x] ?? 1);
  const ys = shownLevels(up, strides[y] ?? 1);
  const spots = xs.flatMap((one, ix) =>
    ys.map((other, iy): Spot => {
      const row = runs.row(fixed.map((level, k) => (k === x ? one.place : k === y ? other.place : level)));
      const at = runs.at(row);
      const value = at === undefined ? null : runs.value(measure.name, at);
      return { row, x: one.value, y: other.value, ix, iy, value, state: at === undefined ? "missing" : stateOf(runs, at, value) };
    }),
  );
  const levels = { xs: xs.map((one) => one.value), ys: ys.map((one) => one.value) };
  return {
    x: scaleOfLevels(titled(along), levels.xs, along.log), y: scaleOfLevels(titled(up), levels.ys, up.log), spots, cells: levels, curves: [],
    ...colourOf(titled(measure), spots),
  };
}

/** Any two columns over each other; coloured by a third, if one is given. Failed runs lie on the lower edge. */
export function scatterOf(runs: Runs, x: Column, y: Column, colour: Column | null, keep = (_at: number): boolean => true): Picture {
  const spots: Spot[] = [];
  const failed: Spot[] = [];
  runs.rows.forEach((row, at) => {
    if (!keep(at)) return;
    const [left, up] = [runs.value(x.name, at), runs.value(y.name, at)];
    const state = stateOf(runs, at, up);
    if (left === null) return;
    if (up === null) failed.push({ row, x: left, y: NaN, value: null, state });
    else spots.push({ row, x: left, y: up, value: colour && runs.value(colour.name, at), state });
  });
  const logOf = (one: Column): boolean => runs.layout.axes.some((axis) => axis.name === one.name && axis.log);
  const high = around(titled(y), [spots.map((spot) => spot.y)], 0.06, [], logOf(y));
  for (const spot of failed) spots.push({ ...spot, y: high.low });
  const wide = around(titled(x), [spots.map((spot) => spot.x)], 0.04, [], logOf(x));
  return { x: wide, y: high, spots, curves: [], ...(colour && colourOf(titled(colour), spots)) };
}

/** The same with a line through some of its spots. */
export function joined(picture: Picture, keep: (spot: Spot) => boolean): Picture {
  const path = (picture.spots ?? []).filter((spot) => spot.state === "ok" && keep(spot)).sort((a, b) => a.x - b.x);
  const line = { x: path.map((spot) => spot.x), y: path.map((spot) => spot.y), look: { ...liveLook(0), width: 2 } };
  return { ...picture, curves: path.length ? [line, { ...line, dots: "full" }] : [] };
}

/** A curve over one axis of a grid. */
export function curveOf(runs: Runs, x: number, fixed: number[], measure: Column): Picture {
  const axis = runs.layout.axes[x] as Axis;
  const others = (at: number): boolean => fixed.every((level, k) => k === x || runs.level(k, runs.rows[at] ?? 0) === level);
  return joined(scatterOf(runs, axis, measure, null, others), () => true);
}
