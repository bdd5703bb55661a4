// What a run in the page gives, and what the static page knows of each scenario; the latter is
// written by martensite.app.static_site.

import type { ScenarioForm } from "../form/types.ts";
import type { Loop, Output, Panel } from "../lib/types.ts";
import type { Views } from "../views/types.ts";

/** A run, with all its samples, in SI. */
/** Rows of a run at its accepted steps, on both sides of jumps; see martensite/simulate/track.py. */
export interface Track {
  times: Float64Array;
  columns: Record<string, Float64Array>;
  /** Weight of every row in an integral over time [s]. */
  weights: Float64Array;
}

export interface RunCore {
  name: string;
  /** The document with its changes, TOML. */
  text: string;
  /** Controls that differ from the packaged document, by path, in SI. */
  changes: Record<string, number>;
  /** Samples that were reached; fewer than asked for if the run left the envelope. */
  times: Float64Array;
  columns: Record<string, Float64Array>;
  /** Outputs at accepted steps, from which numbers and alarms come; null where only samples are known. */
  track: Track | null;
  /** Temperature and fractions along elements, by the name of the output, without a port. */
  profiles: Record<string, Float64Array>;
  status: "OK" | "LONG_STEP" | "OUT_OF_ENVELOPE";
  statusTime: number | null;
  /** Bound on the error, as a share of ranges; null where nothing is estimated. */
  accuracy: number | null;
  steps: number;
  rejected: number;
  /** Longest step [s]. */
  step: number;
  ripple: number;
  residual: number;
  /** Heat put in and lost [J], and accounts [J] in the order of `Scenario.accounts`. */
  putIn: number;
  lost: number;
  accounts: number[];
  /** Where the envelope was left: which bound of `Scenario.envelope`, the value there, when [s]; else null. */
  exit: { place: number; value: number; low: number; high: number; time: number } | null;
  /** All numbers of the system or bench, by path, in SI. */
  parameters: Record<string, number>;
  duration: number;
  tolerance: number;
  samples: number;
  /** Of the calculation [s]. */
  seconds: number;
  /** Sentences about the march: what is not accounted for, where it stopped, a tolerance that was missed. */
  warnings: string[];
  cautions: string[];
}

/** Lengths of what a module reads and writes; its C stands in martensite/simulate. */
export interface Layout {
  /** `adaptive` and `fixed` are `march_on` on a block; `given` is `march` of a system in discrete time. */
  march: "adaptive" | "fixed" | "given";
  size: number;
  drives: number;
  inputs: number;
  /** Where among the inputs of a step the signal of every drive is. */
  places: number[];
  outputs: number;
  /** Numbers of the state that outputs depend on. */
  recorded: number;
  /** Whether fibres or cells of an element share a stress; see `shares_stress` in martensite/simulate/accuracy.py. */
  shares: boolean;
  judged: number;
  envelope: number;
  parameters: number;
  reports: number;
  /** Numbers that are said of a run before the ranges of what is judged. */
  said: number;
  /** Place of the closest decision among them: margin [K], time [s], change, fork, branch; see forks.py. */
  decided: number;
  /** Of each fork its judged fraction, temperature and stress, and its weight in them. */
  forks: [fraction: number, temperature: number, stress: number, weight: number][];
  /** Temperature per stress [K/Pa] with the same effect on a transformation. */
  perStress: number;
  order: 2 | 4 | 5;
}

/** How an entry of the inputs moves with a control: coefficient times the change of a function of it. */
export type Term = [entry: number, shape: Shape, coefficient: number];

/** x, a power of it, or its inverse. */
export type Shape = "x" | "1/x" | "x2" | "root" | "x3" | "1/x2" | "x4" | "1/root";

/** A number control of the form that the page can change by itself. */
export interface Control {
  path: string;
  value: number;
  /** Range in which the map was measured, in SI. */
  low: number;
  high: number;
  terms: Term[];
  /** Cautions that come with any change of it. */
  said: string[];
}

/** How the numbers of a row are read and shown: displayed number = SI · factor + offset. */
export interface NumberRow {
  count: number;
  unit: string;
  factor: number;
  offset: number;
  label: string;
}

/** A drive: so many segments and tones from an entry of the inputs on, column by column; or readings. */
export interface DriveAt {
  segments: number;
  tones: number;
  at: number;
  /** Which of the readings, if there are no segments. */
  readings: number;
  /** Whether it is read at the end of a step. */
  ahead: boolean;
  /** What it is called, and how it is shown; the port that it heats, empty for none. */
  name: string;
  how: { unit: string; display_unit: string; factor: number; offset: number };
  port: string;
}

/** A bound of the envelope, in words. */
export interface Bound {
  /** Output of the module that is bounded. */
  output: number;
  words: string;
  display_unit: string;
  factor: number;
  offset: number;
  reason: string;
  port: string;
  name: string;
}

/** What the page knows of a scenario. */
export interface Scenario {
  name: string;
  title: string;
  text: string;
  described: string;
  /** File of the module, beside this one. */
  module: string;
  layout: Layout;
  form: ScenarioForm;
  /** Spellings of units by SI unit: SI = number * size + zero. */
  units: Record<string, Record<string, [size: number, zero: number]>>;
  /** Inputs at the packaged numbers; infinite ones as text. */
  inputs: (number | string)[];
  places: {
    duration: number;
    tolerance: number;
    samples: number;
    step: number;
    mechanism: number;
    inertial: number;
    interval: number;
    low: number;
    high: number;
    drives: DriveAt[];
    /** Numbers that the form shows and that follow from other controls. */
    dependent: [entry: number, path: string][];
  };
  /** Readings of drives at every step, of 8 bytes in base 64. */
  readings: string[];
  controls: Control[];
  /** Coefficients of products of two changes. */
  products: [entry: number, one: number, other: number, coefficient: number][];
  /** Entries of which the inverse is such a sum. */
  inverted: number[];
  /** Controls which may not be changed together. */
  apart: [one: number, other: number][];
  /** Controls which may be, as long as the first stays below the second. */
  ordered: [less: number, more: number][];
  /** Rows of numbers, by path: their numbers are controls, whose paths end in a place from 0 on. */
  rows: Record<string, NumberRow>;
  /** Paths of controls that need the server. */
  elsewhere: string[];
  /** Paths of parameters, in the order of the inputs. */
  parameters: string[];
  /** Names of the outputs of the module: columns first, profiles after. */
  names: string[];
  columns: number;
  /** Places of judged outputs among all, and the least range of each that counts. */
  judged: [output: number, least: number][];
  envelope: Bound[];
  /** Names of accounts; whether there are balances of heat and work. */
  accounts: string[];
  balances: { heat: boolean; work: boolean };
  /** Sentences of statuses by their number. */
  statuses: Record<string, string>;
  outputs: Record<string, Output>;
  coordinate: string;
  ports: string[];
  traces: Panel[];
  loops: Loop[];
  cautions: string[];
  /** To which share of a range a last digit grows; above 1e-9 `differs` says so. */
  magnified: number;
  differs: string[];
  /** What else the views need; made by martensite.app.views. */
  views: Views;
}

/** The scenarios of the page. */
export interface Manifest {
  version: string;
  scenarios: { name: string; title: string; text: string; file: string; module: string }[];
}
