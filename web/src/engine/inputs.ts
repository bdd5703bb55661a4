// The inputs of a run under changes of controls, by the map that was measured on the builder.

import type { FormNode, NumberNode, SingleNode } from "../form/types.ts";
import { Refusal } from "../lib/refusal.ts";
import type { Control, Scenario, Shape } from "./types.ts";

const SHAPES: Record<Shape, (x: number) => number> = {
  x: (x) => x,
  "1/x": (x) => 1 / x,
  x2: (x) => x * x,
  root: Math.sqrt,
  x3: (x) => x * x * x,
  "1/x2": (x) => 1 / (x * x),
  x4: (x) => x * x * x * x,
  "1/root": (x) => 1 / Math.sqrt(x),
};
/** Share of a number that is rounding. */
const HAIR = 1e-9;
/** Share of its terms that a sum is rounding, and 0. */
const ROUNDING = 8 * Number.EPSILON;

export const SERVER = "Install the Python package and start “martensite app” for this.";

/** Numbers by path in SI; those that are as packaged are left out. */
export type Changes = Record<string, number>;

/** Inputs of a run; throws the sentence of a change that the page cannot make by itself. */
export function predictInputs(scenario: Scenario, changes: Changes): Float64Array {
  const inputs = Float64Array.from(scenario.inputs, Number);
  const moved = findMoved(scenario, changes);
  const steps = new Map<number, Map<number, number>>();
  const sizes = new Map<number, number>();
  const add = (entry: number, term: number): void => {
    sizes.set(entry, (sizes.get(entry) ?? Math.abs(inputs[entry]!)) + Math.abs(term));
    inputs[entry]! += term;
  };
  const invert = (): void => scenario.inverted.forEach((entry) => (inputs[entry] = 1 / inputs[entry]!));
  invert();
  for (const [number, value] of moved) {
    const control = scenario.controls[number]!;
    for (const [entry, shape, coefficient] of control.terms) {
      const step = SHAPES[shape](value) - SHAPES[shape](control.value);
      const known = steps.get(entry) ?? new Map<number, number>();
      steps.set(entry, known.set(number, step));
      add(entry, coefficient * step);
    }
  }
  for (const [entry, one, other, coefficient] of scenario.products) {
    const found = steps.get(entry);
    const x = found?.get(one);
    const y = found?.get(other);
    if (x !== undefined && y !== undefined) add(entry, coefficient * x * y);
  }
  const inverted = new Set(scenario.inverted);
  for (const [entry, size] of sizes) if (!inverted.has(entry) && Math.abs(inputs[entry]!) <= ROUNDING * size) inputs[entry] = 0;
  invert();
  return inputs;
}

/** Numbers of controls and their values; throws where one is out of the range of the map. */
function findMoved(scenario: Scenario, changes: Changes): Map<number, number> {
  const found = new Map<number, number>();
  for (const [path, value] of Object.entries(changes)) {
    const number = scenario.controls.findIndex((one) => one.path === path);
    const control = scenario.controls[number];
    if (!control) throw new Refusal(`This page cannot change \`${path}\` by itself. ${SERVER}`, "server", 501);
    const hair = HAIR * (control.high - control.low);
    if (!(value >= control.low - hair && value <= control.high + hair)) throw new Refusal(outside(scenario, control), "server", 501);
    found.set(number, value);
  }
  for (const [one, other] of scenario.apart) {
    if (!found.has(one) || !found.has(other)) continue;
    const names = [one, other].map((k) => `\`${writtenAt(scenario, scenario.controls[k]!.path)}\``).join(" and ");
    throw new Refusal(`This page cannot change ${names} together. ${SERVER}`, "server", 501);
  }
  for (const [less, more] of scenario.ordered) {
    if (!(found.has(less) && found.has(more)) || found.get(less)! < found.get(more)!) continue;
    const [low, high] = [less, more].map((k) => `\`${scenario.controls[k]!.path}\``);
    throw new Refusal(`${low} must be below ${high}.`, "input", 400);
  }
  return found;
}

function outside(scenario: Scenario, control: Control): string {
  const how = findNode(scenario, control.path);
  const words = [control.low, control.high].map((x) => Number((x * how.factor + how.offset).toPrecision(4)));
  return `This page can change \`${writtenAt(scenario, control.path)}\` from ${words[0]} to ${words[1]} ${how.label} only. ${SERVER}`.replace("  ", " ");
}

/** The entry of the document in which the number of a control stands: its own, or that of its row. */
function writtenAt(scenario: Scenario, path: string): string {
  const above = path.slice(0, path.lastIndexOf("."));
  return scenario.rows[above] ? above : path;
}

/** How the control of a path is shown. */
function findNode(scenario: Scenario, path: string): { factor: number; offset: number; label: string } {
  const row = scenario.rows[writtenAt(scenario, path)];
  return row ?? listNumbers(scenario.form.sections).find((one) => one.path === path) ?? { factor: 1, offset: 0, label: "" };
}

/** All controls of a form. */
export function listControls(items: FormNode[]): SingleNode[] {
  return items.flatMap((one) => (one.sort === "group" ? listControls(one.items) : [one]));
}

/** All number controls of a form. */
export const listNumbers = (items: FormNode[]): NumberNode[] => listControls(items).filter((one) => one.sort === "number");

/** Cautions that come with changes. */
export function listSaid(scenario: Scenario, changes: Changes): string[] {
  return scenario.controls.filter((one) => one.path in changes).flatMap((one) => one.said);
}
