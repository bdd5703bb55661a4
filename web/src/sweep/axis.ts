// One axis of a sweep as the form holds it, and the words that the library takes.

import { readComma } from "../lib/numbers.ts";
import type { Target } from "./types.ts";

export type Kind = "range" | "list" | "normal";

export interface AxisChoice {
  id: number;
  name: string;
  kind: Kind;
  low: string;
  high: string;
  unit: string;
  levels: string;
  log: boolean;
  list: string;
  mean: string;
  deviation: string;
  deviationUnit: string;
}

const SHARE = 0.2;
const ABSOLUTE = 10;
const short = (value: number): string => String(Number(value.toPrecision(4)));

/** Limits around a number, inside of its bounds. */
function around(one: Target): [number, number] {
  const apart = /^deg[CF]$/.test(one.unit) ? ABSOLUTE : Math.abs(one.value) * SHARE;
  const low = apart ? one.value - apart : (one.low ?? 0);
  const high = apart ? one.value + apart : (one.high ?? low + 1);
  return [Math.max(low, one.low ?? -Infinity), Math.min(high, one.high ?? Infinity)];
}

let made = Date.now();

export function axisOf(one: Target): AxisChoice {
  const [low, high] = around(one);
  const middle = short(one.value);
  const degrees = /^deg[CF]$/.test(one.unit);
  made += 1;
  return {
    id: made, name: one.name, kind: "range", low: short(low), high: short(high), unit: one.unit, levels: "9", log: false,
    list: [low, one.value, high].map(short).join(", "), mean: middle, deviation: "2", deviationUnit: degrees ? "K" : "%",
  };
}

const NUMBER_LAST = /(^|[\s,])[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*$/;
const spaced = (...pieces: string[]): string => pieces.map((piece) => piece.trim()).filter(Boolean).join(" ");

/** As `--over` takes it. */
export function wordsOf(axis: AxisChoice, grid: boolean): string {
  const { name, unit } = axis;
  if (axis.kind === "list") return `${name}=${NUMBER_LAST.test(axis.list) ? spaced(axis.list, unit) : axis.list.trim()}`;
  const [low, high, mean, deviation] = [axis.low, axis.high, axis.mean, axis.deviation].map((text) => readComma(text.trim()));
  if (axis.kind === "normal") {
    return `${name}=${spaced(mean ? spaced(mean, unit) : "", "+-", deviation ?? "", axis.deviationUnit)}`;
  }
  const levels = grid && axis.levels.trim() ? `:${axis.levels.trim()}` : "";
  const range = spaced(`${low}..${high}`, unit);
  return `${name}=${range}${levels}${axis.log ? " log" : ""}`;
}
