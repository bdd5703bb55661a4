// Logs of the page: files by key, their columns in SI, and the stretches of them that are records.

import { SERVER } from "../engine/inputs.ts";
import type { Uploaded } from "../lib/api.ts";
import { Refusal } from "../lib/refusal.ts";
import { makeId } from "../lib/tab.ts";
import { quantityOf } from "./headings.ts";
import { decodeText, readTable, type TextTable } from "./text-table.ts";
import { DRIVE, siOf, toSi } from "./units.ts";

/** A table and what its columns mean, as identify/state.ts asks with it. */
export interface LogRequest {
  key: string;
  separator: string;
  drop: boolean;
  interval: number | null;
  columns: { at: number; name: string; unit: string }[];
  steps: unknown[];
  cuts: { name: string; from: number; to: number; every: number }[];
  merge?: boolean;
  further?: LogRequest[];
}

export interface Column {
  si: string;
  values: Float64Array;
}

/** Columns over time, all in SI. */
export interface LogRecord {
  name: string;
  times: Float64Array;
  columns: Map<string, Column>;
  /** Whether the log says its times. */
  timed: boolean;
  dropped: number;
}

const files = new Map<string, { name: string; bytes: Uint8Array; tables: Map<string, TextTable> }>();
const MOST_BYTES = 64 * 2 ** 20;

export async function keepLog(file: Blob & { name?: string }, name = file.name ?? "log"): Promise<Uploaded> {
  if (file.size > MOST_BYTES) throw new Refusal(`\`${name}\` has more than 64 MiB.`, "input", 413);
  const key = makeId();
  files.set(key, { name, bytes: new Uint8Array(await file.arrayBuffer()), tables: new Map() });
  return { key, name, bytes: file.size };
}

export const isKept = (key: string): boolean => files.has(key);

export function findTable(key: string, separator: string): TextTable & { name: string } {
  const file = files.get(key);
  if (!file) throw new Refusal("This page does not have the file any more; choose it again.", "input", 404);
  const table = file.tables.get(separator) ?? readTable(decodeText(file.name, file.bytes), separator);
  file.tables.set(separator, table);
  return { ...table, name: file.name };
}

/** The mapped columns of a table. */
export function readLog(request: LogRequest): LogRecord {
  if (request.merge) throw new Refusal(`This page does not merge logs by itself. ${SERVER}`, "server", 501);
  if (request.steps.length) throw new Refusal(`This page fits logs as they were recorded. ${SERVER}`, "server", 501);
  const table = findTable(request.key, request.separator);
  const used = request.columns.map((one) => ({ ...one, of: table.columns[one.at]!, si: siOfColumn(one) }));
  const wrong = used.find(({ of }) => of.wrong.length);
  if (wrong && !request.drop) {
    throw new Refusal(`Column \`${wrong.name}\` has cells that are no numbers, such as “${wrong.of.wrong[0]}”. Leave out cells that cannot be read, or do not use the column.`, "input", 400);
  }
  const double = used.find((one, k) => used.findIndex((other) => other.name === one.name) !== k);
  if (double) throw new Refusal(`There are two columns \`${double.name}\`; leave one of them out, or give it another name.`, "input", 400);
  const clock = used.find((one) => one.name === "time");
  const all = clock ? toSi(clock.of.numbers, clock.of.clock ? "s" : clock.unit) : Float64Array.from({ length: table.rows }, (_, k) => k * (request.interval ?? 1));
  const rows = keepAscending(all, request.drop);
  const columns = new Map(used.filter((one) => one !== clock).map(({ name, unit, of, si }) => {
    const values = toSi(of.numbers, unit);
    return [name, { si, values: Float64Array.from(rows, (row) => values[row]!) }];
  }));
  const name = table.name.replace(/\.\w+$/, "");
  return { name, times: Float64Array.from(rows, (row) => all[row]!), columns, timed: clock !== undefined, dropped: table.rows - rows.length };
}

function siOfColumn({ name, unit }: { name: string; unit: string }): string {
  const si = siOf(unit);
  if (!unit) throw new Refusal(`Column \`${name}\` needs a unit: choose the one that it is written in.`, "input", 400);
  if (!si) throw new Refusal(`\`${unit}\` is no unit that this page knows for \`${name}\`.`, "input", 400);
  const wanted = quantityOf(name);
  if (wanted && wanted !== DRIVE && wanted !== si) throw new Refusal(`Column \`${name}\` cannot be in \`${unit}\`.`, "input", 400);
  return si;
}

/** Rows with times that rise; others are left out if that is wanted, and refused else. */
function keepAscending(times: Float64Array, drop: boolean): number[] {
  const rows: number[] = [];
  let last = -Infinity;
  for (let k = 0; k < times.length; k++) {
    if (times[k]! > last) {
      rows.push(k);
      last = times[k]!;
    } else if (!drop) {
      const said = Number.isNaN(times[k]!) ? "has no time" : `goes from ${last} s to ${times[k]} s`;
      throw new Refusal(`Time must increase from row to row, but row ${k + 1} ${said}. Leave out what cannot be read, or take another column for the time.`, "input", 400);
    }
  }
  if (rows.length < 2) throw new Refusal("Fewer than two rows have a time.", "input", 400);
  return rows;
}

/** All records of a request: the cuts of every log, or the whole of it. */
export function readRecords(request: LogRequest): LogRecord[] {
  const found = [request, ...(request.further ?? [])].flatMap((one) => {
    const log = readLog(one);
    return one.cuts.length ? one.cuts.map((cut) => cutLog(log, cut)) : [log];
  });
  const double = found.find((one, k) => found.findIndex((other) => other.name === one.name) !== k);
  if (double) throw new Refusal(`There are two records \`${double.name}\`; give one of them another name.`, "input", 400);
  return found;
}

export function cutLog(log: LogRecord, { name, from, to, every }: LogRequest["cuts"][number]): LogRecord {
  const rows = [...log.times.keys()].filter((k) => log.times[k]! >= from && log.times[k]! <= to).filter((_, k) => k % every === 0);
  if (rows.length < 3) throw new Refusal(`Record \`${name}\` has ${rows.length} rows; it needs three at least.`, "input", 400);
  const pick = (values: Float64Array): Float64Array => Float64Array.from(rows, (row) => values[row]!);
  return { ...log, name, times: pick(log.times), columns: new Map([...log.columns].map(([key, { si, values }]) => [key, { si, values: pick(values) }])) };
}

/** A record as a table that `martensite fit` reads. */
export function writeRecord({ times, columns }: LogRecord): string {
  const names = ["time [s]", ...[...columns].map(([name, { si }]) => `${name} [${si}]`)];
  const all = [times, ...[...columns.values()].map((one) => one.values)];
  const lines = [...times.keys()].map((row) => all.map((one) => (Number.isNaN(one[row]!) ? "" : String(one[row]))).join(","));
  return `${[names.join(","), ...lines].join("\n")}\n`;
}

/** Rows of a long column that keep its lows and highs. */
export function findEnvelope(values: Float64Array, most: number): number[] {
  if (values.length <= most) return [...values.keys()];
  const kept = new Set([0, values.length - 1]);
  const parts = most / 2;
  for (let part = 0; part < parts; part++) {
    const [from, to] = [Math.floor((part * values.length) / parts), Math.floor(((part + 1) * values.length) / parts)];
    let [low, high] = [-1, -1];
    for (let k = from; k < to; k++) {
      if (Number.isNaN(values[k]!)) continue;
      if (low < 0 || values[k]! < values[low]!) low = k;
      if (high < 0 || values[k]! > values[high]!) high = k;
    }
    if (low >= 0) kept.add(low).add(high);
  }
  return [...kept].sort((a, b) => a - b);
}

export const orNull = (value: number): number | null => (Number.isFinite(value) ? value : null);

/** Smallest and largest number; NaN where there is none. */
export function findRange(values: Float64Array): [number, number] {
  let [low, high] = [NaN, NaN];
  for (const x of values) {
    if (!(x >= low)) low = Number.isNaN(x) ? low : x;
    if (!(x <= high)) high = Number.isNaN(x) ? high : x;
  }
  return [low, high];
}
