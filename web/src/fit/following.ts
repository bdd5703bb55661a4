// Scenarios of the page whose drives follow a log, as documents and as what the engine needs.

import { findKnown, readChanges } from "../engine/documents.ts";
import { listNumbers, type Changes } from "../engine/inputs.ts";
import { locateFile, readManifest, readScenario } from "../engine/local.ts";
import { readToml, Written, writeToml, type Table, type Value } from "../engine/toml.ts";
import type { Scenario } from "../engine/types.ts";
import type { NumberNode } from "../form/types.ts";
import type { Drive } from "../identify/types.ts";
import { Refusal } from "../lib/refusal.ts";
import type { LogRecord } from "./records.ts";

/** Column that a drive of a unit follows if none is named. */
const NATURAL: Record<string, string> = { V: "voltage", A: "current", W: "power", K: "temperature", N: "force", Pa: "stress", m: "position", "1": "strain" };
/** Units of the kinds of sources. */
const SOURCES: Record<string, string> = {
  current: "A", "linear-amplifier": "V", power: "W", "power-pwm": "W", temperature: "K", voltage: "V", "h-bridge": "1", mosfet: "1", "pwm-voltage": "1",
};
/** Outputs that only say what drives. */
const ECHOES: Record<string, string[]> = { K: ["temperature", "hottest"], V: ["voltage"], A: ["current"], W: ["power"] };
const DUTY = "duty";

const isTable = (value: Value | undefined): value is Table => typeof value === "object" && !Array.isArray(value) && !(value instanceof Written);
const tableAt = (table: Table, name: string): Table => (isTable(table[name]) ? table[name] : {});

function valueAt(table: Table, path: string): Value | undefined {
  const keys = path.split(".");
  return keys.slice(0, -1).reduce(tableAt, table)[keys.at(-1)!];
}

function putAt(table: Table, path: string, value: Value | undefined): void {
  const keys = path.split(".");
  let node = table;
  for (const key of keys.slice(0, -1)) node = isTable(node[key]) ? node[key] : (node[key] = {});
  if (value === undefined) delete node[keys.at(-1)!];
  else node[keys.at(-1)!] = value;
}

/** Every waveform of a document: its path, and the kind of source that it drives. */
function listWaveforms(document: Table): { path: string; kind: string; drive: string }[] {
  const own = tableAt(document, "drive");
  const ports = Object.keys(tableAt(document, "actuators")).map((port) => [port, tableAt(tableAt(tableAt(document, "actuators"), port), "drive")] as const);
  const kindOf = (table: Table): string => (typeof table["kind"] === "string" ? table["kind"] : typeof own["kind"] === "string" ? own["kind"] : "");
  return [
    ...(isTable(document["drive"]) && own["waveform"] !== undefined ? [{ path: "drive.waveform", kind: kindOf(own), drive: "" }] : []),
    ...ports.filter(([, table]) => table["waveform"] !== undefined).map(([port, table]) => ({ path: `actuators.${port}.drive.waveform`, kind: kindOf(table), drive: port })),
    ...Object.keys(tableAt(document, "signals")).map((name) => ({ path: `signals.${name}`, kind: "", drive: name })),
  ];
}

/** The column that a waveform follows; empty for one of its own. */
function followedBy(value: Value | undefined, kind: string): string {
  if (value === "log") return NATURAL[SOURCES[kind] ?? ""] ?? "";
  if (!isTable(value) || value["kind"] !== "log") return "";
  return typeof value["column"] === "string" ? value["column"] : (NATURAL[SOURCES[kind] ?? ""] ?? "");
}

const kindOfWaveform = (value: Value | undefined): string => (typeof value === "string" ? value : isTable(value) && typeof value["kind"] === "string" ? value["kind"] : "");

/** A document whose drive follows a column; its duration is that of the log. */
export function followDrive(text: string, path: string, column: string): string {
  const document = readToml(text);
  putAt(document, path, { kind: "log", column });
  if (isTable(document["run"])) delete document["run"]["duration"];
  return writeToml(document);
}

/** Numbers put into a document, in SI. */
export function writeNumbers(scenario: Scenario, text: string, numbers: Record<string, number>): string {
  const nodes = new Map(listNumbers(scenario.form.sections).map((node) => [node.path, node]));
  const document = readToml(text);
  for (const [path, value] of Object.entries(numbers)) {
    const keys = path.split(".");
    keys.slice(0, -1).forEach((_, depth) => { // a kind that is written in short becomes a table
      const above = keys.slice(0, depth + 1).join(".");
      const short = valueAt(document, above);
      if (typeof short === "string") putAt(document, above, { kind: short });
    });
    const written = writeQuantity(nodes.get(path)!, value);
    putAt(document, path, typeof written === "number" ? new Written(String(written)) : written);
  }
  return writeToml(document);
}

/** A value in SI as documents have it. */
export function writeQuantity({ factor, offset, shown }: NumberNode, value: number): string | number {
  const number = Number((value * factor + offset).toPrecision(9));
  return shown ? `${number} ${shown}` : number;
}

/** A document that may follow a log, and the scenario of the page that it is a variant of. */
export interface Followed {
  scenario: Scenario;
  address: string;
  /** The document. */
  text: string;
  /** The same with waveforms of its own. */
  own: string;
  changes: Changes;
  drives: Drive[];
  /** Place of a drive, and the column that it follows. */
  follows: Map<number, string>;
}

export async function readFollowed(text: string): Promise<Followed> {
  const manifest = await readManifest();
  const document = readToml(text);
  let best: { own: string; name: string; written: Map<string, string> } | null = null;
  for (const one of manifest.scenarios) {
    const own = restoreWaveforms(document, readToml(one.text));
    try {
      const { name, written } = findKnown({ ...manifest, scenarios: [one] }, own);
      if (!best || written.size < best.written.size) best = { own, name, written };
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
    }
  }
  if (!best) findKnown({ ...manifest, scenarios: [] }, text); // which throws the sentence
  const { own, name, written } = best!;
  const scenario = await readScenario(manifest, name);
  const follows = new Map<number, string>();
  const drives = listWaveforms(document).map(({ path, kind, drive }) => {
    const column = followedBy(valueAt(document, path), kind);
    if (column) follows.set(findPlace(scenario, path, drive), column);
    return { path, kind, waveform: kindOfWaveform(valueAt(document, path)), column, what: drive && !kind ? `signal \`${drive}\`` : `drive \`${kind}\`` };
  });
  return { scenario, address: locateFile(scenario.module), text, own, changes: readChanges(scenario, written), drives, follows };
}

/** A document with the waveforms and the duration of a packaged one in place of those that follow a log. */
function restoreWaveforms(document: Table, packaged: Table): string {
  const copy = readToml(writeToml(document));
  const followed = listWaveforms(copy).filter(({ path, kind }) => followedBy(valueAt(copy, path), kind));
  for (const { path } of followed) putAt(copy, path, valueAt(packaged, path));
  const duration = tableAt(packaged, "run")["duration"];
  if (followed.length && duration !== undefined && tableAt(copy, "run")["duration"] === undefined) putAt(copy, "run.duration", duration);
  return writeToml(copy);
}

function findPlace(scenario: Scenario, path: string, drive: string): number {
  const { drives } = scenario.places;
  const heated = drives.filter((one) => one.port);
  const found = path === "drive.waveform" ? (heated.length === 1 ? drives.indexOf(heated[0]!) : -1) : drives.findIndex((one) => one.name === drive);
  if (found < 0) throw new Refusal(`The waveform at \`${path}\` drives several elements: give each its own.`, "input", 400);
  return found;
}

/** Columns of a log that are compared: outputs of the scenario that vary, and do not only say what drives. */
export function matchOutputs(scenario: Scenario, follows: ReadonlyMap<number, string>, { columns }: LogRecord): string[] {
  const taken = new Set(follows.values());
  const echoes = new Set([...follows.keys()].flatMap((place) => {
    const { how, name, port } = scenario.places.drives[place]!;
    const said = port ? (ECHOES[how.unit] ?? []) : [];
    return [...said, ...said.map((one) => `${name}.${one}`), "drive", `${name}.drive`];
  }));
  return [...columns].filter(([name, { si, values }]) => scenario.outputs[name]?.unit === si && !taken.has(name) && !echoes.has(name) && isVarying(values)).map(([name]) => name);
}

const isVarying = (values: Float64Array): boolean => {
  const known = values.filter(Number.isFinite);
  return known.some((x) => x !== known[0]);
};

/** What of a scenario could follow a log: paths of its waveforms and columns; null where something that heats follows none. */
export function matchDrives(text: string, { columns }: LogRecord): Map<string, string> | null {
  const document = readToml(text);
  const found = new Map<string, string>();
  const taken = new Set<string>();
  const { control = "" } = tableAt(document, "mechanism"); // what the command of a testing machine is
  for (const { path, kind, drive } of listWaveforms(document)) {
    const unit = SOURCES[kind] ?? "";
    const natural = unit === "1" ? DUTY : (NATURAL[unit] ?? "");
    const candidates = kind ? (drive ? [`${drive}.drive`, `${drive}.${natural}`] : ["drive", natural]) : [drive, drive === "command" ? control : ""];
    const column = candidates.find((name): name is string => typeof name === "string" && name !== "" && !taken.has(name) && columns.has(name) && (!kind || columns.get(name)!.si === unit));
    if (column) {
      found.set(path, column);
      taken.add(column);
    } else if (kind) return null;
  }
  return found.size ? found : null;
}
