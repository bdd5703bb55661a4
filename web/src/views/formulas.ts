// Formulas of martensite.app.views.formulas: tables of rows, computed from parameters and columns.

export type Row =
  | ["p" | "y" | "first", string]
  | ["c", number | string]
  | [operation: string, ...rows: number[]];

export interface Table {
  rows: Row[];
  /** Conditions by row, and what they must be for the formulas to hold. */
  choices: [row: number, outcome: number][];
}

export type Values = Record<string, number>;
export type Columns = Record<string, ArrayLike<number>>;
/** What a row is: one number, or one for each of the rows of the columns that were asked for. */
export type Value = number | Float64Array;

const nearest = (x: number): number => {
  const low = Math.floor(x);
  const up = x - low;
  return up > 0.5 || (up === 0.5 && low % 2 !== 0) ? low + 1 : low;
};

/** Operations of kernels as floats have them (martensite.kernels.floats), and functions of Python's `math`. */
const OPERATIONS: Record<string, (a: number, b: number, c: number) => number> = {
  add: (a, b) => a + b,
  sub: (a, b) => a - b,
  mul: (a, b) => a * b,
  div: (a, b) => a / b,
  neg: (a) => -a,
  abs: Math.abs,
  lt: (a, b) => Number(a < b),
  le: (a, b) => Number(a <= b),
  gt: (a, b) => Number(a > b),
  ge: (a, b) => Number(a >= b),
  eq: (a, b) => Number(a === b),
  ne: (a, b) => Number(a !== b),
  where: (flag, yes, no) => (flag ? yes : no),
  both: (a, b) => Number(a && b),
  either: (a, b) => Number(a || b),
  negate: (a) => Number(!a),
  minimum: (a, b) => (a < b ? a : b),
  maximum: (a, b) => (a > b ? a : b),
  clip: (x, low, high) => Math.min(Math.max(x, low), high),
  sqrt: (x) => (x > 0 ? Math.sqrt(x) : 0),
  exp: (x) => Math.exp(Math.min(x, 700)),
  log: (x) => Math.log(Math.max(x, 1e-300)),
  power: (base, exponent) => (base > 0 ? Math.min(base ** exponent, Math.exp(700)) : 0),
  sin: Math.sin,
  cos: Math.cos,
  tan: Math.tan,
  tanh: Math.tanh,
  asin: Math.asin,
  atan2: Math.atan2,
  nearest,
  quarter_sine: (x) => Math.sin((Math.PI / 2) * x),
};

function operation(name: string): (a: number, b: number, c: number) => number {
  const found = OPERATIONS[name];
  if (!found) throw new Error(`The page does not know the operation ${name} of a formula.`);
  return found;
}

/** A table with its numbers, of the rows of columns that are asked for. */
export class Computed {
  private readonly values: Value[] = [];

  constructor(
    private readonly table: Table,
    parameters: Values,
    columns: Columns = {},
    rows: readonly number[] = [],
  ) {
    for (const row of table.rows) this.values.push(this.compute(row, parameters, columns, rows));
  }

  private compute(row: Row, parameters: Values, columns: Columns, rows: readonly number[]): Value {
    const [kind, of] = row;
    if (kind === "c") return Number(of);
    if (kind === "p") return require(parameters, of as string, "parameter");
    if (kind === "first") return require(columns, of as string, "column")[0]!;
    if (kind === "y") {
      const column = require(columns, of as string, "column");
      return fillRow(rows.length, (k) => column[rows[k]!]!);
    }
    const apply = operation(kind);
    const given = (row.slice(1) as number[]).map((k) => this.values[k]!);
    if (given.every((one) => typeof one === "number")) return apply(given[0]!, given[1]!, given[2]!);
    const [a, b = a, c = a] = given.map((one) => (typeof one === "number" ? new Float64Array(rows.length).fill(one) : one));
    return fillRow(rows.length, (k) => apply(a![k]!, b![k]!, c![k]!));
  }

  /** Whether all choices come out as they were recorded. */
  get holds(): boolean {
    return this.table.choices.every(([row, outcome]) => {
      const value = this.values[row]!;
      return typeof value === "number" ? value === outcome : value.every((one) => one === outcome);
    });
  }

  /** The value of a row at one of the rows of the columns. */
  at(row: number, k: number): number {
    return at(this.values[row], k);
  }

  /** The value of a row that is one number. */
  one(row: number): number {
    return this.at(row, 0);
  }

  /** The value of a row: one number, or one over time. */
  get(row: number): Value {
    return this.values[row]!;
  }

  /** A text with its numbers written in. */
  write(text: string): string {
    return text.replace(/\x02(\d+):\.(\d+)g\x03/g, (_, row, digits) => formatGeneral(this.one(Number(row)), Number(digits)));
  }
}

/** Numbers by their place. */
export function fillRow(count: number, value: (k: number) => number): Float64Array {
  const found = new Float64Array(count);
  for (let k = 0; k < count; k++) found[k] = value(k);
  return found;
}

const at = (value: Value | undefined, k: number): number => (typeof value === "object" ? value[k]! : value!);

function require<T>(table: Record<string, T>, name: string, kind: string): T {
  const found = table[name];
  if (found === undefined) throw new Error(`There is no ${kind} ${name} for a formula of the page.`);
  return found;
}

export const roundHalfEven = nearest;

/** A number as Python writes it with the format `.{digits}g`. */
export function formatGeneral(value: number, digits: number): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";
  if (value === 0) return Object.is(value, -0) ? "-0" : "0";
  const [mantissa = "", power = "0"] = roundDecimal(value, digits).split("e");
  const exponent = Number(power);
  const trim = (text: string): string => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  if (exponent >= -4 && exponent < digits) return trim(Number(`${mantissa}e${exponent}`).toFixed(Math.max(digits - 1 - exponent, 0)));
  return `${trim(mantissa)}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
}

/** As Python's format `.1e` writes it. */
export function formatPower(value: number): string {
  const [size = "", exponent = "0"] = value.toExponential(1).split("e");
  const number = Number(exponent);
  return `${size}e${number < 0 ? "-" : "+"}${String(Math.abs(number)).padStart(2, "0")}`;
}

/** With so many digits, ties to even. */
function roundDecimal(value: number, digits: number): string {
  const exact = value.toExponential(Math.min(digits + 30, 100));
  const [mantissa = "", power = "0"] = exact.split("e");
  const sign = mantissa.startsWith("-") ? 1 : 0;
  const kept = mantissa.slice(0, sign + (digits > 1 ? digits + 1 : 1));
  const rest = mantissa.slice(sign + digits + 1);
  const tie = /^50*$/.test(rest) && Number(kept.at(-1)) % 2 === 0;
  return tie ? `${kept}e${power}` : value.toExponential(digits - 1);
}
