// Which scenario of the page a document is, and which of its controls are changed.

import type { ScenarioForm } from "../form/types.ts";
import { Refusal } from "../lib/refusal.ts";
import { listNumbers, SERVER, type Changes } from "./inputs.ts";
import { changeDocument, flattenTable, readToml, writeToml } from "./toml.ts";
import type { Manifest, Scenario } from "./types.ts";

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
  if (!best) throw new Refusal(`This page runs the scenarios that come with it, and their numbers. ${SERVER}`, "server", 501);
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
    const node = nodes.get(path);
    if (!node) throw new Refusal(`This page cannot change \`${path}\` by itself. ${SERVER}`, "server", 501);
    const value = readQuantity(scenario, node.unit ?? "1", text, path);
    if (node.value === null || Math.abs(value - node.value) > 1e-12 * Math.abs(node.value)) found[path] = value;
  }
  return found;
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
    if (typeof value === "string" || typeof value === "number") continue;
    throw new Refusal(`This page cannot change \`${path}\` by itself. ${SERVER}`, "server", 501);
  }
  return writeToml(changeDocument(readToml(text), Object.fromEntries(given) as Record<string, string | number>));
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
  const shown = new Map(scenario.places.shown.map(([entry, path]) => [path, inputs[entry]!]));
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
  return { ...form, text, notes: [], assumed: [], missing: [], refused: "" };
}
