// Changes that bring a run below an exceeded limit. Runs find them: a first guess, then corrections until no alarm is left.

import { quantity } from "../form/scale.ts";
import type { NumberNode, RowNode } from "../form/types.ts";
import { toShown } from "../lib/numbers.ts";
import type { Alarm, Run } from "../lib/types.ts";
import { DRIVEN, listHeats, scaled, unitOf, type Changes, type Entries } from "./remedies.ts";
import { peakOf, startOf } from "./results.ts";

/** Alarms of limits that damage the wire or the supply. */
const DANGEROUS = ["temperature", "stress", "strain", "rig"];

export interface Cure {
  key: string;
  words: string;
  changes: Changes;
  run: Run;
}

/** A number that can bring an alarm to an end. */
export interface Knob {
  key: string;
  /** Factor of the number for an excess (worst value / limit). */
  factor: (over: number) => number;
  /** The changes, in words too, for a factor and a fraction of the heat. */
  apply: (factor: number, share: number) => { words: string; changes: Changes };
  /** Initial fraction of the heat if the wire must reach its previous temperature; otherwise null. */
  share: number | null;
}

/** Exceeded limits of a run, the largest excess first. */
export const dangersOf = (run: Run): Alarm[] =>
  run.alarms.filter(({ kind }) => DANGEROUS.includes(kind)).sort((a, b) => overOf(b, run) - overOf(a, run));

/** Worst value divided by the limit; temperatures count from the start of the run. */
export function overOf({ kind, worst, limit }: Alarm, run: Run): number {
  const zero = kind === "temperature" ? startOf(run, "temperature") : 0;
  return (worst - zero) / (limit - zero);
}

/** Quantities that load an element. */
const LOADS = /^mechanism\.(mass|payload|force|moment|preload|stiffness|spring_stiffness)$/;
/** Corrections aim at this fraction of the limit. */
const SAFE = 0.995;
/** Runs per knob. */
const MOST_RUNS = 5;
/** Tolerance of the restored temperature rise. */
const NEAR = 0.03;
/** A cure retains this fraction of the stroke. */
const MOVES = 0.4;

/** A value with two digits, not above the given one. */
const roundDown = (value: number): number => roundTo(value, 0.1, Math.floor);

/** A value with one digit or five in the second, not below the given one: diameters are sold like this. */
const roundUp = (value: number): number => roundTo(value, 0.5, Math.ceil);

function roundTo(value: number, grain: number, round: (value: number) => number): number {
  const step = grain * 10 ** Math.floor(Math.log10(Math.abs(value)));
  return Number((round(Number((value / step).toPrecision(9))) * step).toPrecision(6));
}

const lower = (words: string): string => words.charAt(0).toLowerCase() + words.slice(1);

function setNumber(node: NumberNode, factor: number, round: (value: number) => number): { words: string; changes: Changes } {
  const value = round(toShown((node.value ?? 0) * factor, node));
  return { words: `${lower(node.title)} ${value} ${node.label}`.trim(), changes: { [node.path]: quantity(node, value) } };
}

/** A drive with three digits. */
const setHeat = (node: NumberNode | RowNode, factor: number): Changes =>
  node.sort === "number" ? setNumber(node, factor, (value) => Number(value.toPrecision(3))).changes : { [node.path]: scaled(node, factor) };

function loads(entries: Entries): Knob[] {
  return [...entries.numbers.values()]
    .filter((node) => LOADS.test(node.path) && (node.value ?? 0) > 0)
    .map((node) => ({ key: node.path, factor: (over) => 1 / over, apply: (factor) => setNumber(node, factor, roundDown), share: null }));
}

/** A thicker wire, heated to its previous temperature. */
function thicker(entries: Entries): Knob[] {
  const node = entries.numbers.get("element.diameter");
  const heats = listHeats(entries);
  if (!node?.value) return [];
  const apply: Knob["apply"] = (factor, share) => {
    const own = setNumber(node, factor, roundUp);
    // the resistance falls with the square of the diameter
    const resistance = (toShown(node.value ?? 0, node) / Number.parseFloat(String(own.changes[node.path]))) ** 2;
    const driven = heats.map((heat) => setHeat(heat, DRIVEN[unitOf(heat)]?.(share, resistance) ?? 1));
    return { words: `${own.words}${heats.length ? ", heated to the same temperature" : ""}`, changes: Object.assign({}, own.changes, ...driven) as Changes };
  };
  return [{ key: node.path, factor: (over) => Math.sqrt(over), apply, share: heats.length ? 1 : null }];
}

function longer(entries: Entries): Knob[] {
  const node = entries.numbers.get("element.length");
  return node?.value ? [{ key: node.path, factor: (over) => over, apply: (factor) => setNumber(node, factor, roundUp), share: null }] : [];
}

/** Less heat; currents and voltages act by their square. */
function weaker(entries: Entries): Knob[] {
  const heats = listHeats(entries);
  const first = heats[0];
  if (!first) return [];
  const unit = unitOf(first);
  const word = { W: "power", A: "current", V: "voltage" }[unit] ?? "drive";
  const apply: Knob["apply"] = (factor) => {
    const percent = Math.min(95, Math.ceil(100 * (1 - factor)));
    return { words: `${percent} % less ${word}`, changes: Object.fromEntries(heats.map((node) => [node.path, scaled(node, 1 - percent / 100)])) };
  };
  return [{ key: "heat", factor: (over) => (unit === "W" ? 1 / over : 1 / Math.sqrt(over)), apply, share: null }];
}

/** Numbers that can end an alarm of a kind, the most direct first. */
export function knobsOf(entries: Entries, kind: string): Knob[] {
  if (kind === "stress") return [...loads(entries), ...thicker(entries), ...weaker(entries)];
  if (kind === "strain") return [...longer(entries), ...loads(entries), ...weaker(entries)];
  return weaker(entries);
}

/** Rise of the hottest element above the start [K]. */
const riseOf = (run: Run): number => (peakOf(run, "hottest") ?? NaN) - startOf(run, "temperature");

/** Whether a run has fewer exceeded limits, no alarm of the kind, and still moves. */
function isCure(after: Run, before: Run, { kind, port }: Alarm): boolean {
  const left = dangersOf(after);
  const gone = !left.some((one) => one.kind === kind && one.port === port);
  return gone && left.length < dangersOf(before).length && after.stroke >= MOVES * before.stroke;
}

/** Return the change of one knob that ends an alarm; null if the tried values do not. */
export async function findCure(knob: Knob, alarm: Alarm, before: Run, ask: (changes: Changes) => Promise<Run>): Promise<Cure | null> {
  let [factor, share] = [knob.factor(overOf(alarm, before)), knob.share ?? 1];
  for (let runs = 0; runs < MOST_RUNS; runs++) {
    const { words, changes } = knob.apply(factor, share);
    const run = await ask(changes);
    const left = run.alarms.find(({ kind, port }) => kind === alarm.kind && port === alarm.port);
    const ratio = knob.share === null ? 1 : riseOf(before) / riseOf(run);
    const isHot = !Number.isFinite(ratio) || Math.abs(ratio - 1) < NEAR;
    if (!left && isHot) return isCure(run, before, alarm) ? { key: knob.key, words, changes, run } : null;
    if (left) factor *= knob.factor(overOf(left, run) / SAFE);
    if (!isHot) share *= ratio;
  }
  return null;
}
