// What a run in the page gives, and what the static page knows of each scenario; the latter is
// written by martensite_app.static_site.

import type { ScenarioForm } from "../form/types.ts";
import type { Loop, Output, Panel } from "../lib/types.ts";

/** A run, with all its samples, in SI. */
export interface RunCore {
  name: string;
  /** The document with its changes, TOML. */
  text: string;
  /** Controls that differ from the packaged document, by path, in SI. */
  changes: Record<string, number>;
  /** Samples that were reached; fewer than asked for if the run left the envelope. */
  times: Float64Array;
  columns: Record<string, Float64Array>;
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
}

/** Constants of a module; the C stands in martensite/simulate. */
export interface Layout {
  /** `adaptive` and `fixed` are `march_on` on a block; `given` is `march` of a system in discrete time. */
  march: "adaptive" | "fixed" | "given";
  size: number;
  drives: number;
  inputs: number;
  outputs: number;
  judged: number;
  envelope: number;
  parameters: number;
  /** Numbers that are said of a run before the ranges of what is judged. */
  said: number;
  order: 2 | 4;
}

/** How an entry of the inputs follows from controls: a sum of products of functions of one control each. */
export interface Term {
  entry: number;
  coefficient: number;
  /** Controls (by number) and the functions of each. */
  of: [control: number, shape: Shape][];
}

/** x, 1/x, x², √x, x³, 1/x². */
export type Shape = "x" | "1/x" | "x2" | "root" | "x3" | "1/x2";

/** A number control of the form that the page can change by itself. */
export interface Control {
  path: string;
  value: number;
  /** Range in which the map was measured, in SI. */
  low: number;
  high: number;
  /** Numbers of controls which may not be changed together with this one. */
  apart: number[];
}

/** Segments and tones of a drive: where they begin among the inputs. */
export interface DriveAt {
  segments: number;
  tones: number;
  at: number;
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
  /** Unit spellings by SI unit: SI = number * size + zero. */
  units: Record<string, Record<string, [size: number, zero: number]>>;
  /** Inputs at the packaged numbers, in one list: parameters, then what `places` names. */
  inputs: number[];
  places: {
    duration: number;
    tolerance: number;
    samples: number;
    /** Longest step; -1 for none. */
    step: number;
    /** First step of the mechanism [s], which may be infinite (written as null). */
    mechanism: number;
    inertial: number;
    limits: number;
    drives: DriveAt[];
  };
  controls: Control[];
  terms: Term[];
  /** Paths of parameters, in the order of the inputs. */
  parameters: string[];
  /** Names of the outputs of the module, columns first, profiles after. */
  names: string[];
  columns: number;
  /** Places of judged outputs, the least range of each that counts. */
  judged: [output: number, least: number][];
  /** Port and output of every bound. */
  envelope: [port: string, output: string][];
  accounts: string[];
  outputs: Record<string, Output>;
  coordinate: string;
  ports: string[];
  traces: Panel[];
  loops: Loop[];
  cautions: string[];
  /** What else the views need; made by martensite_app.views. */
  views: unknown;
}

/** The scenarios of the page. */
export interface Manifest {
  version: string;
  scenarios: { name: string; title: string; text: string; file: string }[];
}
