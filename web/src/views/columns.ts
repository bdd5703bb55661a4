// Columns as they are drawn: rows that are kept, stretches of heating and cooling.

import { RIPPLE, STILL } from "../engine/constants.ts";
import type { RunCore } from "../engine/types.ts";
import type { Panel, Stretch } from "../lib/types.ts";
import { TOGETHER } from "./alarms.ts";
import type { Numbers } from "./excursions.ts";
import { roundHalfEven, type Columns } from "./formulas.ts";

/** Points that are drawn of a column; more cannot be told apart on a screen. */
const MOST_ROWS = 2001;
/** Most stretches that are told apart. */
const MOST_TURNS = 32;
/** Share of the largest value of a column that is 0. */
const ROUNDING = 1e-9;

/** Rows, at most so many, first and last among them. */
export function chooseRows(count: number, most = MOST_ROWS): number[] {
  if (count <= most) return Array.from({ length: count }, (_, k) => k);
  return Array.from({ length: most }, (_, k) => roundHalfEven((k * (count - 1)) / (most - 1)));
}

export const pickRows = (column: Numbers, rows: number[]): number[] => rows.map((k) => column[k]!);

/** Rows of a run that are drawn: evenly chosen ones, and the lowest and highest of every column. */
export function chooseCurveRows(count: number, columns: Record<string, Numbers>): number[] {
  const kept = chooseRows(count);
  if (kept.length === count) return kept;
  const ends = Object.values(columns).flatMap((column) => [placeOf(column, 1), placeOf(column, -1)]);
  return [...new Set([...kept, ...ends])].sort((a, b) => a - b);
}

/** First row of the highest value of a column, or of the lowest where the sign is -1. */
function placeOf(column: Numbers, sign: 1 | -1): number {
  let found = 0;
  for (let k = 1; k < column.length; k++) if (sign * column[k]! > sign * column[found]!) found = k;
  return found;
}

/** Samples and accepted steps of a run, in the order of time. */
export function mergeRows({ times, columns, track }: Pick<RunCore, "times" | "columns" | "track">): Pick<RunCore, "times" | "columns"> {
  if (!track) return { times, columns };
  const all = join(track.times, times);
  const order = Array.from(all, (_, k) => k).sort((a, b) => all[a]! - all[b]! || a - b);
  const merge = (both: Float64Array): Float64Array => Float64Array.from(order, (k) => both[k]!);
  return { times: merge(all), columns: Object.fromEntries(Object.entries(columns).map(([name, own]) => [name, merge(join(track.columns[name]!, own))])) };
}

function join(one: Float64Array, other: Float64Array): Float64Array {
  const found = new Float64Array(one.length + other.length);
  found.set(one);
  found.set(other, one.length);
  return found;
}

/** Lowest and highest value of every column; a tiny share of the largest is 0, as in `Result.find_range`. */
export const endsOf = (columns: Record<string, Numbers>): Record<string, [low: number, high: number]> =>
  Object.fromEntries(
    Object.entries(columns).map(([name, column]) => {
      const [low, high] = [lowest(column), highest(column)];
      const nothing = ROUNDING * Math.max(Math.abs(low), Math.abs(high));
      return [name, [Math.abs(low) > nothing ? low : 0, Math.abs(high) > nothing ? high : 0]];
    }),
  );

export const highest = (column: Numbers): number => {
  let found = -Infinity;
  for (let k = 0; k < column.length; k++) found = Math.max(found, column[k]!);
  return found;
};

export const lowest = (column: Numbers): number => {
  let found = Infinity;
  for (let k = 0; k < column.length; k++) found = Math.min(found, column[k]!);
  return found;
};

/** Where a path of temperatures [K] is heated, cooled or neither; turns within a ripple are none. */
export function listStretches(temperature: number[]): Stretch[] {
  const found = splitRuns(findSenses(temperature));
  return found.length <= MOST_TURNS ? found : [[0, 0, temperature.length - 1]];
}

function findSenses(temperature: number[]): number[] {
  const ripple = Math.max(RIPPLE * (highest(temperature) - lowest(temperature)), STILL);
  const found = new Array<number>(temperature.length - 1).fill(0);
  let [sense, turn, low, high] = [0, 0, 0, 0];
  temperature.forEach((value, k) => {
    if (value < temperature[low]!) low = k;
    if (value > temperature[high]!) high = k;
    if (sense <= 0 && value - temperature[low]! > ripple) {
      found.fill(sense, turn, low);
      [turn, sense, high] = [sense ? low : 0, 1, k];
    } else if (sense >= 0 && temperature[high]! - value > ripple) {
      found.fill(sense, turn, high);
      [turn, sense, low] = [sense ? high : 0, -1, k];
    }
  });
  return found.fill(sense, turn);
}

function splitRuns(senses: number[]): Stretch[] {
  const found: Stretch[] = [];
  senses.forEach((sense, k) => {
    const last = found.at(-1);
    if (last?.[0] === sense) last[2] = k + 1;
    else found.push([sense, k, k + 1]);
  });
  return found;
}

/** Panels without columns that show the numbers of an earlier one of the panel, as those of the only temperature. */
export function dropRepeated(panels: Panel[], columns: Columns): Panel[] {
  const kept = (own: string[]): string[] =>
    own.reduce<string[]>((found, name) => {
      const base = name.slice(name.lastIndexOf(".") + 1);
      const repeated = base in TOGETHER && found.some((other) => equal(columns[name]!, columns[other]!));
      return repeated ? found : [...found, name];
    }, []);
  const entries = (panel: Panel) => Object.entries(panel.ports).map(([port, own]) => [port, kept(own)] as const);
  return panels.map((panel) => ({ ...panel, ports: Object.fromEntries(entries(panel)) }));
}

function equal(a: Numbers, b: Numbers): boolean {
  for (let k = 0; k < a.length; k++) if (a[k] !== b[k]) return false;
  return true;
}
