// Columns as they are drawn: rows that are kept, stretches of heating and cooling.

import type { Panel, Stretch } from "../lib/types.ts";
import { TOGETHER } from "./alarms.ts";
import type { Numbers } from "./excursions.ts";
import { roundHalfEven, type Columns } from "./formulas.ts";

/** Points that are drawn of a column; more cannot be told apart on a screen. */
const MOST_ROWS = 2001;
/** Most stretches that are told apart. */
const MOST_TURNS = 32;
/** Share of the range of temperature below which a change is no turn. */
const RIPPLE = 0.04;
/** Range of temperature of an isothermal path [K]. */
const STILL = 1e-6;

/** Rows, at most so many, first and last among them. */
export function chooseRows(count: number, most = MOST_ROWS): number[] {
  if (count <= most) return Array.from({ length: count }, (_, k) => k);
  return Array.from({ length: most }, (_, k) => roundHalfEven((k * (count - 1)) / (most - 1)));
}

export const pickRows = (column: Numbers, rows: number[]): number[] => rows.map((k) => column[k]!);

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
