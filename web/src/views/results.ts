// The few numbers to take away from a run, out of its columns: how far, how fast, how hot, how much energy.

import { measureRotor } from "./rotor.ts";
import type { Output, Run } from "../lib/types.ts";

type Column = ArrayLike<number>;

/** Shares of the stroke between which a mechanism counts as moved and as back again. */
const [MOST, LEAST] = [0.9, 0.1];
/** Share of a power that counts as heating, and of the duration that a pause between pulses takes at most. */
const [HALF, PULSE] = [0.5, 0.02];
/** A stroke of less is the error of rounding [SI]. */
const NOTHING = 1e-9;
/** What goes out more often in one run shakes; it has no time up. */
const SHAKES = 10;

/** What is known of the first time that the mechanism goes out and comes back; null for what the run does not show. */
export interface Cycle {
  /** From the beginning of heat to 90 % of the stroke [s]. */
  up: number | null;
  /** From the end of heat until 10 % of the stroke are left [s]. */
  down: number | null;
  /** The part of `down` in which it stays beyond 90 % [s]. */
  wait: number | null;
  /** When heating ends [s]. */
  off: number | null;
  /** Whether the times are those from 10 % to 90 % and back: heat neither begins nor ends them. */
  isOfCurve: boolean;
  /** How often it goes out. */
  count: number;
}

/** A number to take away. */
export interface Measure {
  key: string;
  name: string;
  /** SI; null where the run does not show it. */
  value: number | null;
  how: Pick<Output, "display_unit" | "factor" | "offset">;
  /** How it is meant. */
  about: string;
  /** 1 if more is better, -1 if less is, 0 if neither. */
  better: -1 | 0 | 1;
}

const SECONDS = { display_unit: "s", factor: 1, offset: 0 };
const PER_MINUTE = { display_unit: "/min", factor: 60, offset: 0 };

const namesOf = (run: Run, name: string): string[] => (run.ports.length > 1 ? run.ports.map((port) => `${port}.${name}`) : [name]);

/** Columns of this name, of all ports. */
export function columnsOf(run: Run, name: string): Column[] {
  return namesOf(run, name).flatMap((one) => (run.columns[one] ? [run.columns[one]] : []));
}

/** How the columns of this name are shown. */
export const howOf = (run: Run, name: string): Output | undefined => run.outputs[run.ports.length > 1 ? `${run.ports[0]}.${name}` : name];

/** Highest value of all columns of a name; null if there is none. */
export function peakOf(run: Run, name: string): number | null {
  const found = Math.max(...namesOf(run, name).map((one) => run.ends[one]?.[1] ?? -Infinity));
  return Number.isFinite(found) ? found : null;
}

/** Value of a column at the start of the run, of the first port. */
export const startOf = (run: Run, name: string): number => run.columns[namesOf(run, name)[0]!]?.[0] ?? 0;

/** The same question about the same run is answered once. */
function once<T>(answer: (run: Run) => T): (run: Run) => T {
  const known = new WeakMap<Run, { found: T }>();
  return (run) => {
    const had = known.get(run) ?? { found: answer(run) };
    known.set(run, had);
    return had.found;
  };
}

/** Way of the coordinate from where it begins, as a share of the largest; null if it stays. */
export const measureTravel = once(readTravel);

function readTravel(run: Run): Float64Array | null {
  const x = run.columns[run.coordinate];
  if (!x?.length) return null;
  let far = 0;
  for (let k = 0; k < x.length; k++) if (Math.abs(x[k]! - x[0]!) > Math.abs(far)) far = x[k]! - x[0]!;
  return Math.abs(far) > NOTHING ? Float64Array.from(x, (value) => (value - x[0]!) / far) : null;
}

/** Time at which a column goes through a level, upwards or downwards, after a row; null if it does not. */
export function findCrossing(times: Column, y: Column, level: number, sense: 1 | -1, from = 0): number | null {
  for (let k = Math.max(from, 1); k < y.length; k++) {
    const [a, b] = [y[k - 1]!, y[k]!];
    if (sense * (b - level) >= 0 && sense * (a - level) < 0) return times[k - 1]! + ((level - a) / (b - a)) * (times[k]! - times[k - 1]!);
  }
  return null;
}

type Span = [begin: number, end: number];

/** Power that heats, of all ports together [W]. */
function heatOf(run: Run): number[] {
  const powers = columnsOf(run, "power");
  return run.times.map((_, k) => powers.reduce((sum, one) => sum + one[k]!, 0));
}

/** Spans of time in which a power is above a level; pauses between pulses are none. */
function spansOf(times: number[], power: number[], level: number): Span[] {
  const pause = PULSE * (times.at(-1)! - times[0]!);
  const spans: Span[] = [];
  power.forEach((one, k) => {
    if (!(one > level)) return;
    const last = spans.at(-1);
    // a step between two samples may be at either: the row before it began, the row after ends it
    const [begin, end] = [times[k]!, times[Math.min(k + 1, times.length - 1)]!];
    if (last && begin - last[1] <= pause) last[1] = end;
    else spans.push([begin, end]);
  });
  return spans;
}

function countOf(y: Column): number {
  let [count, out] = [0, false];
  for (let k = 0; k < y.length; k++) {
    if (!out && y[k]! > 0.75) [count, out] = [count + 1, true];
    else if (out && y[k]! < 0.25) out = false;
  }
  return count;
}

const rowAfter = (times: Column, time: number): number => {
  let k = 0;
  while (k < times.length && times[k]! <= time) k++;
  return k;
};

/** How long the mechanism takes out and back; null if it does not move, or shakes. */
export const cycleOf = once(findCycle);

function findCycle(run: Run): Cycle | null {
  const y = measureTravel(run);
  const count = y ? countOf(y) : 0;
  if (!y || count > SHAKES) return null;
  const there = findCrossing(run.times, y, MOST, 1);
  const alone = run.ports.length < 2 && !findTracked(run);
  return (alone && there !== null && byHeat(run, y, there, count)) || byCurve(run, y, there, count);
}

/** Times from where heat begins and ends, of one element that alone moves the mechanism. */
function byHeat(run: Run, y: Column, there: number, count: number): Cycle | null {
  const { times } = run;
  const power = heatOf(run);
  const begun = spansOf(times, power, HALF * power.reduce((a, b) => Math.max(a, b), 0)).filter(([begin]) => begin < there).at(-1);
  if (!begun) return null;
  const row = rowAfter(times, there);
  const left = findCrossing(times, y, MOST, -1, row);
  const held = power.slice(row, left === null ? undefined : rowAfter(times, left));
  const level = held.length ? (HALF * held.reduce((a, b) => a + b, 0)) / held.length : 0;
  const until = spansOf(times, power, level).filter(([begin]) => begin < (left ?? Infinity) && begin <= Math.max(there, begun[0])).at(-1)?.[1] ?? null;
  const off = until !== null && until < times.at(-1)! - NOTHING ? until : null;
  const back = off === null ? null : findCrossing(times, y, LEAST, -1, Math.max(row, 1));
  const up = there - begun[0];
  if (off === null || back === null || back < off) return { up, down: null, wait: null, off, isOfCurve: false, count };
  return { up, down: back - off, wait: left === null ? null : Math.max(left - off, 0), off, isOfCurve: false, count };
}

/** Times from 10 % to 90 % and back. */
function byCurve({ times }: Run, y: Column, there: number | null, count: number): Cycle {
  const begun = findCrossing(times, y, LEAST, 1);
  const left = there === null ? null : findCrossing(times, y, MOST, -1, rowAfter(times, there));
  const back = left === null ? null : findCrossing(times, y, LEAST, -1, rowAfter(times, left));
  return {
    up: there === null || begun === null || there < begun ? null : there - begun,
    down: back === null || left === null ? null : back - left,
    wait: null, off: null, isOfCurve: true, count,
  };
}

/** The position that a controller should hold, if the run has one of the coordinate's unit. */
export function findTracked(run: Run): { reference: Column; actual: Column } | null {
  const [reference, actual] = [run.columns["reference"], run.columns[run.coordinate]];
  const same = run.outputs["reference"]?.unit === run.outputs[run.coordinate]?.unit;
  return reference && actual && same ? { reference, actual } : null;
}

/** Deviation from the reference: its root mean square [SI], and the share of its square that arises while it must cool. */
export const measureDeviation = once(findDeviation);

function findDeviation(run: Run): { rms: number; cooling: number } | null {
  const both = findTracked(run);
  const y = measureTravel(run);
  const x = run.columns[run.coordinate];
  if (!both || !y || !x) return null;
  let [sum, cooling, time] = [0, 0, 0];
  const far = Array.from(y).findIndex((one) => Math.abs(one) > 0.5);
  const sense = Math.sign((x[far] ?? 0) - x[0]!) || 1;
  for (let k = 1; k < run.times.length; k++) {
    const dt = run.times[k]! - run.times[k - 1]!;
    const error = both.actual[k]! - both.reference[k]!;
    sum += error * error * dt;
    if (sense * error > 0) cooling += error * error * dt;
    time += dt;
  }
  return time > 0 ? { rms: Math.sqrt(sum / time), cooling: sum > 0 ? cooling / sum : 0 } : null;
}

/** Electrical energy that the run takes [J]; null if nothing is heated by a current. */
export function energyOf(run: Run): number | null {
  return run.energy.courses.find((course) => course.key === "electrical")?.values.at(-1) || null;
}

/** The numbers to take away, in the order of a question: how far, how fast, how hot, how much. */
export const measures = once((run: Run): Measure[] => [...motions(run), ...peaks(run), ...energies(run)]);

function motions(run: Run): Measure[] {
  const how = run.outputs[run.coordinate];
  if (!how) return [];
  if (run.resonance) return measureRotor(run);
  const cycle = cycleOf(run);
  const error = measureDeviation(run);
  const own = { display_unit: how.display_unit, factor: how.factor, offset: 0 };
  const found: Measure[] = [
    { key: "stroke", name: "Stroke", value: run.stroke, how: own, about: `Range of the ${how.long_name}`, better: 1 },
  ];
  if (error) {
    found.push({ key: "error", name: "Error, RMS", value: error.rms, how: own, about: "Root mean square of position minus reference over the whole run", better: -1 });
  }
  const [up, down] = cycle?.isOfCurve
    ? ["From 10 % to 90 % of the stroke, the first time", "From 90 % back to 10 % of the stroke, the first time"]
    : ["From where the power passes half of its peak to 90 % of the stroke, the first time", "From where the power falls to half of what held it until 10 % of the stroke are left, the first time"];
  if (!error && cycle) {
    found.push({ key: "up", name: "Time up", value: cycle.up, how: SECONDS, about: up, better: -1 });
    found.push({ key: "down", name: "Time down", value: cycle.down, how: SECONDS, about: down, better: -1 });
    const rate = cycle.up && cycle.down ? 1 / (cycle.up + cycle.down) : null;
    if (!cycle.isOfCurve) found.push({ key: "rate", name: "Cycle rate", value: rate, how: PER_MINUTE, about: "Most cycles per minute with this drive: the time up and the time down, without a pause", better: 1 });
  }
  return found;
}

function peaks(run: Run): Measure[] {
  const rows: [key: string, name: string, column: string, about: string][] = [
    ["temperature", "Peak temperature", "hottest", "Hottest place of all elements"],
    ["stress", "Peak stress", "stress", "Largest stress of all elements"],
  ];
  return rows.flatMap(([key, name, column, about]) => {
    const value = peakOf(run, column);
    const how = howOf(run, column);
    return how && value ? [{ key, name, value, how, about, better: -1 as const }] : [];
  });
}

function energies(run: Run): Measure[] {
  const total = energyOf(run);
  if (total === null) return [];
  const count = measureDeviation(run) ? 1 : (cycleOf(run)?.count ?? 1) || 1;
  const came = cycleOf(run)?.down != null && !measureDeviation(run);
  const value = total / count;
  return [
    {
      key: "energy", name: came ? "Energy per cycle" : "Energy", value, how: { display_unit: "J", factor: 1, offset: 0 }, better: -1,
      about: came ? `Electrical energy of the run, ${count === 1 ? "which is one cycle" : `over its ${count} cycles`}` : "Electrical energy of the whole run",
    },
  ];
}

/** Sentences of a law that begin to matter at a stress: only where the run comes half as far do they concern it. */
export function isConcerned(run: Run, sentence: string): boolean {
  const level = /above ([\d.e+]+) MPa/.exec(sentence)?.[1];
  const peak = peakOf(run, "stress");
  return level === undefined || peak === null || 2e-6 * peak >= Number(level);
}
