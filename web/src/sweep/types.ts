// What the server tells of sweeps; see martensite.app.calls.sweeps and its neighbours.

export interface Target {
  name: string;
  about: string;
  unit: string;
  value: number;
  words: string;
  /** Bounds in the shown unit; null for none. */
  low: number | null;
  high: number | null;
  /** Whether the lower bound itself is left out. */
  open: boolean;
}

export interface Named {
  name: string;
  about: string;
}

export interface Measure extends Named {
  /** Whether it may stand without an output. */
  alone: boolean;
  usual: string;
}

export interface Form {
  title: string;
  text: string;
  targets: Target[];
  designs: Named[];
  measures: Measure[];
  outputs: (Named & { unit: string })[];
  usual: string[];
  runtimes: string[];
  cores: number;
}

export interface Plan {
  faults: Record<string, string>;
  runs: number | null;
  command: string;
  cautions: string[];
  runtime?: string;
}

export interface Estimate {
  seconds: number;
  tried: number;
  took: number;
  workers: number;
  step: number | null;
  runtime: string;
}

/** A column: displayed number = SI * factor + offset. */
export interface Column {
  name: string;
  short: string;
  about: string;
  unit: string;
  display_unit: string;
  factor: number;
  offset: number;
}

export interface Axis extends Column {
  log: boolean;
  /** All levels of a grid, in SI; null for a sample. */
  levels: number[] | null;
}

export interface Layout {
  title: string;
  sample: string;
  runs: number;
  over: string[];
  text: string;
  seed: number;
  step: number | null;
  runtime: string;
  version: string;
  axes: Axis[];
  measures: Column[];
  /** Every how many-th level of each axis, or run of a sample, is drawn. */
  strides: number[];
  statuses: [number, string, string][];
}

export interface Points {
  rows: number[];
  status: number[];
  columns: Record<string, (number | null)[]>;
}

export interface Line {
  key: string;
  title: string;
  over: string[];
  sample: string;
  runs: number;
  done: number;
  state: "running" | "done" | "stopped" | "unreadable";
  why: string;
  made: number;
  bytes: number;
  path: string;
}

export interface Stored extends Line {
  layout: Layout;
  points: Points;
  counts: Record<string, number>;
  failed: [number, number, number[]][];
  command: string;
}

export interface Note {
  phase: "preparing" | "running";
  number: number;
  key?: string;
  runs?: number;
  done?: number;
  rate?: number | null;
  left?: number | null;
  counts?: Record<string, number>;
  remarks?: string[];
  rows?: number[];
  status?: number[];
  columns?: Record<string, (number | null)[]>;
}

export interface Outcome {
  key: string | null;
  stopped: string;
  done?: number;
  runs?: number;
  seconds?: number;
  cautions?: string[];
}
