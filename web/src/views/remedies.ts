// What might help a run, as changes of its document. Each is told by a run of its own, never by a rule.

import { quantity } from "../form/scale.ts";
import type { FormNode, GroupNode, NumberNode, RowNode } from "../form/types.ts";
import { toShown } from "../lib/numbers.ts";
import type { Aim } from "./insight.ts";

export type Changes = Record<string, unknown>;

export interface Remedy {
  key: string;
  /** Behind “with”. */
  words: string;
  /** What it stands for. */
  about: string;
  /** Changes of the document, with so large a share of the heat of each wire. */
  changes: (share: number) => Changes;
  /** The share to begin with, where the wire shall get as hot as it did; null where it gets as hot as it may. */
  share: number | null;
  /** So many wires stand in the place of one. */
  wires: number;
}

const plain = (changes: Changes): Pick<Remedy, "changes" | "share" | "wires"> => ({ changes: () => changes, share: null, wires: 1 });

/** What a remedy reads of a form: numbers by their paths, lists of quantities, kinds. */
export interface Entries {
  numbers: Map<string, NumberNode>;
  rows: Map<string, RowNode>;
  kinds: Map<string, string>;
}

export function entriesOf(sections: GroupNode[]): Entries {
  const found: Entries = { numbers: new Map(), rows: new Map(), kinds: new Map() };
  const walk = (node: FormNode): void => {
    if (node.sort === "number") found.numbers.set(node.path, node);
    else if (node.sort === "row") found.rows.set(node.path, node);
    else if (node.sort === "group") {
      if (node.kind) found.kinds.set(node.kind.path, node.kind.value);
      node.items.forEach(walk);
    }
  };
  sections.forEach(walk);
  return found;
}

const HEAT_UNITS = ["W", "A", "V"];

/** Numbers of the drive's waveform that say how strongly it heats. */
export function listHeats(entries: Entries): (NumberNode | RowNode)[] {
  const isHeat = (path: string): boolean => path.startsWith("drive.waveform.");
  const numbers = [...entries.numbers.values()].filter((node) => isHeat(node.path) && node.value !== null && HEAT_UNITS.includes(node.unit ?? ""));
  const strong = numbers.filter((node) => node.value !== 0);
  const rows = [...entries.rows.values()].filter((node) => isHeat(node.path) && node.path.endsWith(".values"));
  return [...strong, ...rows];
}

/** A list of quantities times a factor. */
export const scaledRow = (text: string, factor: number): string[] =>
  text.split(",").map((part) => {
    const [, number = "0", unit = ""] = /^\s*([-+\d.e]+)\s*(.*?)\s*$/i.exec(part) ?? [];
    return `${Number((Number(number) * factor).toPrecision(12))} ${unit}`.trim();
  });

export const scaled = (node: NumberNode | RowNode, factor: number): unknown =>
  node.sort === "row" ? scaledRow(node.value, factor) : quantity(node, Number(toShown((node.value ?? 0) * factor, node).toPrecision(12)));

export const unitOf = (node: NumberNode | RowNode): string =>
  node.sort === "number" ? (node.unit ?? "") : (/[A-Za-z]+\s*$/.exec(node.value)?.[0].trim() ?? "");

/** What of a mechanism is shared by wires side by side, so that each has its part of it. */
const SHARED: Record<string, string[]> = {
  "dead-weight": ["mass"],
  "bias-spring": ["stiffness", "preload"],
  finger: ["stiffness", "mass", "damping", "inertia"],
};
/** Drivers of which a controller sets the share of a voltage: thinner wires take their current by themselves. */
const VOLTAGE = ["mosfet", "pwm-voltage", "voltage"];
const SERIES = ["series_resistance", "supply_resistance", "on_resistance", "resistance"];

/** Factor of a drive for a fraction of the heat and a ratio of resistances, by unit. */
export const DRIVEN: Record<string, (share: number, resistance: number) => number> = {
  W: (share) => share, A: (share, resistance) => Math.sqrt(share / resistance), V: (share, resistance) => Math.sqrt(share * resistance),
};

/** Four wires of half the diameter have the section of one; run as one of them, with a quarter of the load. */
function thinner(entries: Entries): Remedy | null {
  const diameter = entries.numbers.get("element.diameter");
  const shared = SHARED[entries.kinds.get("mechanism.kind") ?? ""];
  const driver = entries.kinds.get("driver.kind");
  if (!diameter || !shared || entries.kinds.get("element.kind") !== "wire" || (driver && !VOLTAGE.includes(driver))) return null;
  const changes = (share: number): Changes => {
    const made: Changes = { [diameter.path]: scaled(diameter, 0.5) };
    const take = (node: NumberNode | undefined, factor: number): void => {
      if (node?.value) made[node.path] = scaled(node, factor);
    };
    shared.forEach((name) => take(entries.numbers.get(`mechanism.${name}`), 0.25));
    for (const node of listHeats(entries)) made[node.path] = scaled(node, DRIVEN[unitOf(node)]?.(share, 4) ?? 1);
    for (const part of ["drive", "driver"]) SERIES.forEach((name) => take(entries.numbers.get(`${part}.${name}`), 4));
    return made;
  };
  const isDriven = listHeats(entries).length > 0;
  return {
    key: "thinner", words: `four parallel wires of half the diameter${isDriven ? ", heated to the same temperature" : ""}`, changes, share: isDriven ? 0.5 : null, wires: 4,
    about: "Same cross-section and stress, twice the surface. The run simulates one of the four wires with a quarter of the load.",
  };
}

/** The stream of a fan that begins when heating ends. */
function blown(entries: Entries, off: number | null): Remedy | null {
  const kind = entries.kinds.get("environment.cooling.kind");
  const h = entries.numbers.get("environment.cooling.h");
  const free = ["churchill-chu", "morgan", "lefevre-ede"];
  if (!kind || off === null || !(free.includes(kind) || (kind === "constant" && h))) return null;
  const still = kind === "constant" && h ? { kind, h: quantity(h, toShown(h.value ?? 0, h)) } : { kind };
  return {
    key: "blown", words: "a fan of 2 m/s during cooling",
    about: "A fan that follows the switch of the drive, with the correlation of Churchill and Bernstein.",
    ...plain({ "environment.cooling": { kind: "fan", still }, "signals.fan": { kind: "step", high: "2 m/s", at: `${Number(off.toPrecision(6))} s` } }),
  };
}

function warmer(entries: Entries, factor: number): Remedy | null {
  const nodes = listHeats(entries);
  if (!nodes.length) return null;
  const size = `${Math.abs(100 * (factor - 1)).toFixed(0)} %`;
  const word = { W: "power", A: "current", V: "voltage" }[unitOf(nodes[0]!)] ?? "drive";
  return {
    key: factor < 1 ? "weaker" : "stronger", words: `${size} ${factor < 1 ? "less" : "more"} ${word}`,
    about: factor < 1 ? "The wire stays cooler and returns sooner." : "The wire transforms sooner and gets hotter.",
    ...plain(Object.fromEntries(nodes.map((node) => [node.path, scaled(node, factor)]))),
  };
}

function colder(entries: Entries): Remedy | null {
  const node = entries.numbers.get("environment.temperature");
  if (!node?.value) return null;
  const value = quantity(node, Number(toShown(node.value - 10, node).toPrecision(12)));
  return { key: "colder", words: "an ambient temperature 10 K lower", about: "More heat is lost at every temperature, also during heating.", ...plain({ [node.path]: value }) };
}

function loaded(entries: Entries): Remedy | null {
  const names = { "dead-weight": "mass", "bias-spring": "preload" }[entries.kinds.get("mechanism.kind") ?? ""];
  const node = names && entries.numbers.get(`mechanism.${names}`);
  if (!node || !node.value) return null;
  return { key: "loaded", words: `a quarter more ${names}`, about: "Stress shifts the transformation to higher temperatures, so the wire returns sooner.", ...plain({ [node.path]: scaled(node, 1.25) }) };
}

function gained(entries: Entries): Remedy | null {
  const node = [...entries.numbers.values()].find((one) => /^controllers?\.(\w+\.)?Kp$/.test(one.path));
  if (!node?.value) return null;
  return { key: "gained", words: "twice the proportional gain", about: "The controller heats more for the same error, if the drive has the power.", ...plain({ [node.path]: scaled(node, 2) }) };
}

/** What might help, the likeliest first. */
export function remediesOf(entries: Entries, aim: Aim, off: number | null): Remedy[] {
  const cool = [thinner(entries), blown(entries, off), warmer(entries, 0.85), loaded(entries), colder(entries)];
  const heat = [warmer(entries, 1.25), thinner(entries)];
  const found = aim === "heating" || aim === "motion" ? heat : aim === "error" ? [gained(entries), ...cool] : cool;
  return found.filter((one) => one !== null);
}
