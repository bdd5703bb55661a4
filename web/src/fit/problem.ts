// What is to be fitted to what, and numbers as shares of their ranges.

import type { Changes } from "../engine/inputs.ts";
import type { DriveTable } from "../engine/march.ts";

/** A number that is searched for, by the path of its control; in SI. */
export interface FreeNumber {
  path: string;
  start: number;
  low: number;
  high: number;
  log: boolean;
}

/** An output beside its column. */
export interface Compared {
  /** Place among the outputs of the module. */
  at: number;
  measured: Float64Array;
  /** What residuals are divided by. */
  scale: number;
  /** 1 for rows that the fit sees. */
  used: Uint8Array;
}

export interface FittedRecord {
  /** From 0 s on. */
  times: Float64Array;
  /** Signals that follow a column, by the place of their drive. */
  drives: [place: number, table: DriveTable][];
  compared: Compared[];
}

export interface Problem {
  /** Numbers that stay as they are, as far as they differ from the packaged document. */
  changes: Changes;
  free: FreeNumber[];
  records: FittedRecord[];
}

/** Modelled outputs by record and output, at all rows. */
export type Curves = Float64Array[][];

export const toValue = ({ low, high, log }: FreeNumber, share: number): number =>
  log ? low * (high / low) ** share : low + share * (high - low);
export const toShare = ({ low, high, log }: FreeNumber, value: number): number =>
  log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
/** Change of the value with its share. */
export const findSlope = (free: FreeNumber, value: number): number =>
  free.log ? value * Math.log(free.high / free.low) : free.high - free.low;
