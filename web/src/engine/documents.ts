// Which scenario of the page a document is, and which of its controls are changed.

import type { ScenarioForm } from "../form/types.ts";
import { Refusal } from "../lib/refusal.ts";
import { listControls, listNumbers, SERVER, type Changes } from "./inputs.ts";
import { changeDocument, flattenTable, readList, readToml, writeToml, type Given } from "./toml.ts";
import type { Manifest, NumberRow, Scenario } from "./types.ts";

const QUANTITY = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$/;

/** A document that belongs to a scenario of the page. */
export interface Known {
  name: string;
  /** Path and what is written there, where that differs from the packaged document. */
  written: Map<string, string>;
}

/** The scenario of which a document is a variant; throws the sentence where there is none. */
export function findKnown(manifest: Manifest, text: string): Known {
  const own = readDocument(text);
  let best: Known | null = null;
  for (const one of manifest.scenarios) {
    if (one.text === text) return { name: one.name, written: new Map() };
    const base = readPackaged(one.text);
    if ([...base.keys()].some((path) => !own.has(path) && !liesAbove(path, own))) continue;
    const written = new Map([...own].filter(([path, value]) => base.get(path) !== value));
    if (!best || written.size < best.written.size) best = { name: one.name, written };
  }
  if (!best) throw new Refusal(`This page runs its own scenarios only. ${SERVER}`, "server", 501);
  return best;
}

const packaged = new Map<string, Map<string, string>>();

/** The entries of a packaged document, read once. */
function readPackaged(text: string): Map<string, string> {
  const found = packaged.get(text) ?? flattenTable(readToml(text));
  packaged.set(text, found);
  return found;
}

/** Whether a kind that was written in short has become a table. */
const liesAbove = (path: string, own: Map<string, string>): boolean => own.has(`${path}.kind`);

function readDocument(text: string): Map<string, string> {
  try {
    return flattenTable(readToml(text));
  } catch (error) {
    throw new Refusal(error instanceof Error ? error.message : String(error), "input", 400);
  }
}

/** Values in SI of what is written in another way than in the packaged document. */
export function readChanges(scenario: Scenario, written: Map<string, string>): Changes {
  const base = readPackaged(scenario.text);
  const nodes = new Map(listNumbers(scenario.form.sections).map((node) => [node.path, node]));
  const found: Changes = {};
  for (const [path, text] of written) {
    const short = path.endsWith(".kind") ? path.slice(0, -5) : "";
    if (short && base.get(short) === text) continue;
    const row = scenario.rows[path];
    if (row) {
      readRow(scenario, path, row, text).forEach(([place, value]) => (found[place] = value));
      continue;
    }
    const node = nodes.get(path);
    if (!node) throw new Refusal(`This page cannot change \`${path}\` by itself. ${SERVER}`, "server", 501);
    const value = readQuantity(scenario, node.unit ?? "1", text, path);
    if (node.value === null || differsFrom(value, node.value)) found[path] = value;
  }
  return found;
}

const differsFrom = (value: number, packaged: number): boolean => Math.abs(value - packaged) > 1e-12 * Math.abs(packaged);

/** Paths and values of the numbers of a row that are others than the packaged ones. */
function readRow(scenario: Scenario, path: string, row: NumberRow, text: string): [string, number][] {
  const items = readList(text);
  if (!items) throw new Refusal(`\`${path}\` must be a list, but is \`${text}\`.`, "input", 400);
  if (items.length !== row.count) throw new Refusal(`This page keeps the ${row.count} numbers of \`${path}\`, but ${items.length} were given. ${SERVER}`, "server", 501);
  const known = new Map(scenario.controls.map((one) => [one.path, one.value]));
  const read = items.map((item, k): [string, number] => [`${path}.${k}`, readQuantity(scenario, row.unit, item, path)]);
  return read.filter(([place, value]) => differsFrom(value, known.get(place)!));
}

function readQuantity(scenario: Scenario, unit: string, text: string, path: string): number {
  const [, number, spelling] = QUANTITY.exec(text.replace(/^"|"$/g, "")) ?? [];
  const units = scenario.units[unit] ?? {};
  const how = spelling ? units[spelling.replace("°C", "degC").replace("µ", "u").replace("Ω", "ohm")] : unit === "1" ? ([1, 0] as const) : undefined;
  if (number !== undefined && how) return Number(number) * how[0] + how[1];
  const spelled = Object.keys(units).slice(0, 4).join("`, `");
  throw new Refusal(`\`${path}\` needs a number with a unit such as \`${spelled || "1"}\`, but is \`${text}\`.`, "input", 400);
}

/** A document with changes as they are typed. */
export function writeChanged(text: string, changes: Record<string, unknown>): string {
  const given = Object.entries(changes);
  if (!given.length) return text;
  for (const [path, value] of given) {
    if ((Array.isArray(value) ? value : [value]).every((one) => typeof one === "string" || typeof one === "number")) continue;
    throw new Refusal(`This page cannot change \`${path}\` by itself. ${SERVER}`, "server", 501);
  }
  return writeToml(changeDocument(readToml(text), Object.fromEntries(given) as Record<string, Given>));
}

/** What differs between documents, as the call `compare` answers. */
export function compareDocuments(texts: string[]): { rows: { path: string; values: (string | null)[] }[] } {
  const documents = texts.map(readDocument);
  const paths = [...new Set(documents.flatMap((one) => [...one.keys()]))];
  const rows = paths.map((path) => ({ path, values: documents.map((one) => one.get(path) ?? null) }));
  return { rows: rows.filter(({ values }) => values.some((value) => value !== values[0])) };
}

/** The form of a scenario under changes; what follows from other controls moves, too. */
export function fillForm(scenario: Scenario, text: string, changes: Changes, inputs: Float64Array): ScenarioForm {
  const form = structuredClone(scenario.form);
  const ranges = new Map(scenario.controls.map((one) => [one.path, one]));
  const shown = new Map(scenario.places.dependent.map(([entry, path]) => [path, inputs[entry]!]));
  for (const node of listNumbers(form.sections)) {
    const range = ranges.get(node.path);
    if (node.slider && range) node.slider = { ...node.slider, low: range.low, high: range.high };
    else node.slider = null;
    const value = changes[node.path] ?? shown.get(node.path);
    if (value === undefined) continue;
    node.value = value;
    if (!(node.path in changes)) continue;
    node.changed = true;
    node.origin = { sort: "scenario", words: "written in the scenario" };
  }
  const own = flattenTable(readToml(text));
  for (const node of listControls(form.sections)) {
    if (node.sort === "row" && scenario.rows[node.path]) node.value = readList(own.get(node.path) ?? "")?.join(", ") ?? node.value;
  }
  return { ...form, text, notes: [], assumed: [], missing: [], refused: "" };
}
