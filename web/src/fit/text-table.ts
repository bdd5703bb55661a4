// Tables as text: comma, semicolon, tab or blanks between cells, decimal commas, headings with units, lines in front.

import { Refusal } from "../lib/refusal.ts";
import { SERVER } from "../engine/inputs.ts";
import { findUnit } from "./units.ts";

export interface TextColumn {
  heading: string;
  /** Unit of a row of units below the headings. */
  unit: string;
  /** NaN where there is none. */
  numbers: Float64Array;
  /** Cells that are no numbers. */
  wrong: string[];
  /** Whether it holds times of day, read as seconds. */
  clock: boolean;
}

export interface TextTable {
  separator: string;
  headed: boolean;
  preview: string[][];
  rows: number;
  columns: TextColumn[];
  /** Whether numbers have a decimal comma. */
  commas: boolean;
  notes: string[];
}

const SPLITS: Record<string, (line: string) => string[]> = {
  tab: (line) => line.split("\t"),
  semicolon: (line) => line.split(";"),
  comma: (line) => splitQuoted(line),
  whitespace: (line) => line.trim().split(/\s+/),
};
const NUMBER = /^[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?$/;
const CLOCK = /^(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d+)?)$/;
const NONE = /^(|-|--|nan|null|none|n\/a|na)$/i;
const [LOOKED, PREVIEW] = [400, 8];
/** More rows than this are thinned out on the next page, or read by the server. */
export const MOST_ROWS = 200_000;
const OTHERS = /\.(xlsx?|mat|nc|parquet|tdms|mcap|gz|zip|h5|hdf5)$/i;

/** The text of a file; refuses what is none. */
export function decodeText(name: string, bytes: Uint8Array): string {
  const wide = (bytes[0] === 0xff && bytes[1] === 0xfe) || (bytes[0] === 0xfe && bytes[1] === 0xff);
  const isText = wide || !bytes.subarray(0, 4096).includes(0);
  if (!isText || OTHERS.test(name)) {
    throw new Refusal(`This page reads tables as text: \`${name}\` is none. Excel, MAT, netCDF, Parquet, TDMS, MCAP and packed files are read by the server. ${SERVER}`, "input", 415);
  }
  if (wide) return new TextDecoder(bytes[0] === 0xff ? "utf-16le" : "utf-16be").decode(bytes);
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

function splitQuoted(line: string): string[] {
  if (!line.includes('"')) return line.split(",");
  return [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) => quoted ?? plain ?? "");
}

const cleanCell = (cell: string): string => cell.trim().replace(/^"(.*)"$/, "$1").trim();
const isNumeric = (cell: string): boolean => NUMBER.test(cell) || CLOCK.test(cell);

/** A number, seconds of a clock, or NaN. */
function readNumber(cell: string): number {
  const clock = CLOCK.exec(cell);
  if (clock) return 3600 * Number(clock[1]) + 60 * Number(clock[2]) + Number(clock[3]!.replace(",", "."));
  return NUMBER.test(cell) ? Number(cell.replace(",", ".")) : NaN;
}

export function readTable(text: string, separator: string): TextTable {
  const lines = text.replace(/^\ufeff/, "").split(/\r\n|\n|\r/).filter((line) => line.trim() && !/^\s*#/.test(line));
  const chosen = separator === "auto" ? chooseSeparator(lines) : separator;
  const cells = lines.map((line) => SPLITS[chosen]!(line).map(cleanCell));
  const begin = cells.findIndex((row, k) => isData(row) && (k + 1 >= cells.length || isData(cells[k + 1]!)));
  if (begin < 0) throw new Refusal("No rows of numbers were found in this file.", "input", 400);
  const data = cells.slice(begin).filter(isData);
  const lost = cells.length - begin - data.length;
  const width = findWidth(data);
  const [headings, units] = readHeadings(cells.slice(0, begin), width);
  const columns = Array.from({ length: width }, (_, at) => readColumn(data, at, headings[at] ?? "", units[at] ?? ""));
  const uneven = data.filter((row) => row.length !== width).length;
  const notes = [
    ...(lost ? [`${lost} row${lost > 1 ? "s" : ""} without numbers ${lost > 1 ? "are" : "is"} left out.`] : []),
    ...(uneven ? [`${uneven} row${uneven > 1 ? "s have" : " has"} more or fewer cells than the others.`] : []),
    ...(width === 1 ? ["There is one column only; if the file has more, choose its separator."] : []),
    ...(columns.some((one) => one.wrong.length) ? ["Some cells are no numbers. Do not use their columns, or leave out such cells."] : []),
  ];
  if (data.length > MOST_ROWS) throw new Refusal(`This page reads ${MOST_ROWS.toLocaleString("en")} rows, and the file has ${data.length.toLocaleString("en")}. Longer logs are read by the server. ${SERVER}`, "input", 413);
  const commas = chosen !== "comma" && data.slice(0, LOOKED).some((row) => row.some((cell) => /^[+-]?\d*,\d/.test(cell)));
  return { separator: chosen, headed: headings.length > 0, preview: data.slice(0, PREVIEW), rows: data.length, columns, commas, notes };
}

const isData = (row: string[]): boolean => {
  const known = row.filter(isNumeric).length;
  return known > 0 && 2 * (known + row.filter((cell) => NONE.test(cell)).length) > row.length;
};

/** The one by which most rows are numbers in equally many cells. */
function chooseSeparator(lines: string[]): string {
  const some = lines.slice(0, LOOKED);
  let best = ["whitespace", 0] as [string, number];
  for (const [name, split] of Object.entries(SPLITS)) {
    const rows = some.map((line) => split(line).map(cleanCell)).filter((row) => row.length > 1 && row.every((cell) => isNumeric(cell) || NONE.test(cell)) && isData(row));
    const width = findWidth(rows);
    const count = rows.filter((row) => row.length === width).length;
    if (count > best[1]) best = [name, count];
  }
  return best[0];
}

/** How many cells most rows have. */
function findWidth(rows: string[][]): number {
  const counts = new Map<number, number>();
  for (const row of rows) counts.set(row.length, (counts.get(row.length) ?? 0) + 1);
  return [...counts].sort((a, b) => b[1] - a[1])[0]?.[0] ?? 0;
}

/** Headings, and units of a row of their own below them. */
function readHeadings(before: string[][], width: number): [string[], string[]] {
  const last = before.at(-1);
  if (!last || Math.abs(last.length - width) > 1 || last.every((cell) => !cell)) return [[], []];
  const above = before.at(-2);
  const spelled = last.map((cell) => findUnit(cell.replace(/^[[(](.*)[\])]$/, "$1")));
  const isUnits = above && Math.abs(above.length - width) <= 1 && last.every((cell, k) => spelled[k] || NONE.test(cell)) && !above.every((cell) => findUnit(cell));
  return isUnits ? [above, spelled] : [last, []];
}

function readColumn(data: string[][], at: number, heading: string, unit: string): TextColumn {
  const numbers = new Float64Array(data.length);
  const wrong: string[] = [];
  let clock = false;
  let days = 0;
  data.forEach((row, k) => {
    const cell = row[at] ?? "";
    numbers[k] = readNumber(cell);
    if (CLOCK.test(cell)) {
      clock = true;
      if (k && numbers[k]! + days < numbers[k - 1]! - 43200) days += 86400;
      numbers[k]! += days;
    } else if (Number.isNaN(numbers[k]) && !NONE.test(cell)) wrong.push(cell);
  });
  return { heading, unit, numbers, wrong, clock };
}
