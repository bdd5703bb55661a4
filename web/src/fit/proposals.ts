// What a log may be explained by: scenarios of the page that take its drive, the simplest first, and what is free in them.

import { listNumbers } from "../engine/inputs.ts";
import { readManifest } from "../engine/local.ts";
import type { Control, Scenario } from "../engine/types.ts";
import type { NumberNode } from "../form/types.ts";
import type { ProposalView, ProposedModel, Quantity } from "../identify/types.ts";
import { Refusal } from "../lib/refusal.ts";
import { followDrive, matchDrives, matchOutputs, readFollowed, type Followed } from "./following.ts";
import type { LogRecord } from "./records.ts";

export const MOST_FREE = 6;
/** A range over so many times its low end is searched on a logarithmic scale. */
const WIDE = 30;
/** Controls that say how it is driven and run, and no number of the device. */
const NO_DEVICE = /^(run|signals|reference|references|bench)\.|(^|\.)waveform\./;
const SHAPE = ["A_s", "A_f", "M_s", "M_f"];
const MOVES = ["position", "strain", "angle", "elongation", "force", "stress", "crosshead", "lift"];

export interface Choosable extends Quantity {
  control: Control;
  node: NumberNode;
}

/** All numbers that may be free: those of the device that the page can change. */
export function listChoosable({ scenario, changes }: Pick<Followed, "scenario" | "changes">): Choosable[] {
  const nodes = new Map(listNumbers(scenario.form.sections).map((node) => [node.path, node]));
  return scenario.controls.filter(({ path }) => nodes.has(path) && !NO_DEVICE.test(path) && !nodes.get(path)?.slider?.whole).map((control) => {
    const node = nodes.get(control.path)!;
    const { factor, offset, shown, meaning, allowed, origin, unit } = node;
    const { path, low, high, value } = control;
    return {
      name: nameNumber(scenario, path), group: path.split(".").slice(0, -1).join("."), places: 1, value: changes[path] ?? value,
      low, high, allowed, doc: meaning, origin: origin.words, unit: unit ?? "1", shown, factor, offset, control, node,
    };
  });
}

/** The last part of a path, as \`martensite fit --free\` takes it, where that names one number. */
function nameNumber(scenario: Scenario, path: string): string {
  const last = path.split(".").at(-1)!;
  const ends = (one: string): boolean => one.split(".").at(-1) === last;
  return scenario.parameters.filter(ends).length <= 1 && scenario.controls.filter((one) => ends(one.path)).length === 1 ? last : path;
}

export const isLogarithmic = (low: number, high: number): boolean => low > 0 && high / low > WIDE;

/** Names that a log of such outputs tells, the most telling first: as the library frees them for such a log. */
function listUsual(outputs: string[]): string[] {
  const told = outputs.map((name) => name.split(".").at(-1)!);
  const moves = told.some((name) => MOVES.includes(name));
  return [
    ...(moves || told.includes("temperature") ? SHAPE : []),
    ...(told.includes("resistance") ? ["rho_M", "rho_A"] : []),
    ...(told.includes("temperature") ? ["h", "latent_heat"] : []),
    ...(moves ? ["eps_L", "H_sat", "h", "stiffness"] : []),
  ];
}

export function chooseFree(followed: Pick<Followed, "scenario" | "changes">, outputs: string[]): Choosable[] {
  const known = listChoosable(followed);
  const { controls, apart } = followed.scenario;
  const place = (one: Choosable): number => controls.indexOf(one.control);
  const chosen: Choosable[] = [];
  for (const name of listUsual(outputs)) {
    const one = known.find(({ control }) => control.path.split(".").at(-1) === name);
    const clash = one && chosen.some((other) => apart.some((pair) => pair.includes(place(one)) && pair.includes(place(other))));
    if (one && !clash && !chosen.includes(one) && chosen.length < MOST_FREE) chosen.push(one);
  }
  return chosen;
}

interface Candidate {
  model: ProposedModel;
  outputs: string[];
  /** Numbers of state and of parameters: how much there is to it. */
  size: number;
}

export async function proposeScenarios(records: LogRecord[]): Promise<ProposalView> {
  const log = records[0]!;
  const { scenarios } = await readManifest();
  const found: Candidate[] = [];
  for (const one of scenarios) {
    const drives = matchDrives(one.text, log);
    const candidate = drives && (await considerScenario(one, drives, log));
    if (candidate) found.push(candidate);
  }
  found.sort((a, b) => b.outputs.length - a.outputs.length || a.size - b.size);
  const [best] = found;
  if (!best) return { kind: "", said: "", refused: sayNone(log), notes: [], models: [] };
  const compared = best.outputs.map((name) => `\`${name}\``).join(", ");
  const why = found.length > 1 ? "of the scenarios that explain most columns it has the fewest states and numbers" : "it is the only scenario of this page that takes this drive and has these outputs";
  const said = `\`${best.model.name}\` comes first: ${why}. Compared: ${compared}.`;
  return { kind: "run", said, refused: "", notes: [], models: found.map((one) => one.model), best: best.model.name };
}

/** A scenario whose drives follow columns; null where it cannot, or has no output of the log. */
async function considerScenario({ text, title }: { text: string; title: string }, drives: Map<string, string>, log: LogRecord): Promise<Candidate | null> {
  try {
    const followed = await readFollowed([...drives].reduce((document, [path, column]) => followDrive(document, path, column), text));
    const { layout } = followed.scenario;
    const outputs = matchOutputs(followed.scenario, followed.follows, log);
    if (layout.march === "given" || !outputs.length) return null;
    return { model: describeModel(title, followed, outputs), outputs, size: layout.size + layout.parameters / 1000 };
  } catch (error) {
    if (error instanceof Refusal) return null;
    throw error;
  }
}

function describeModel(title: string, followed: Followed, outputs: string[]): ProposedModel {
  const free = chooseFree(followed, outputs).map(({ name, unit, shown, factor, offset, value, low, high, doc }) => ({
    name, unit, shown, factor, offset, doc, low: null, high: null, start: null, scale: null, usual: [value, low!, high!] as [number, number, number],
  }));
  return { name: title, text: followed.text, free, each: [], starts: 0 };
}

function sayNone({ columns }: LogRecord): string {
  const names = [...columns.keys()].map((name) => `\`${name}\``).join(", ");
  return `No scenario of this page is driven by a column of this log and has another as an output (${names || "no columns"}). Say what the columns are: one must be a power, current, voltage, duty or temperature that drives, another an answer such as position, strain, force, temperature or resistance.`;
}
