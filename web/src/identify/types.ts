// What the server tells of a log, of a scenario beside it, and of a fit; see martensite.app.calls: logs
// and fits. Numbers are in SI.

/** How something is shown: displayed number = SI * factor + offset. */
export interface Shown {
  unit: string;
  display_unit: string;
  factor: number;
  offset: number;
}

export interface TableColumn {
  heading: string;
  name: string;
  unit: string;
  min: number | null;
  max: number | null;
  missing: number;
  wrong: number;
  first_wrong: string;
  curve: [number[], (number | null)[]];
}

export interface TableView {
  name: string;
  /** How the file is written, what its columns are, what was left out, in one sentence. */
  said: string;
  /** Whether its columns are those of a known experiment. */
  recognised: boolean;
  rows: number;
  separator: string;
  headed: boolean;
  preview: string[][];
  columns: TableColumn[];
  /** Known names, each with the units it may be in. */
  names: Record<string, string[]>;
  notes: string[];
}

export interface RecordsView {
  begin: number;
  end: number;
  rows: number;
  dropped: number;
  /** Whether the log says its times. */
  timed: boolean;
  columns: (Shown & { name: string; times: number[]; values: (number | null)[]; before: (number | null)[]; missing: number })[];
  /** What was done to the log, in words. */
  steps: string[];
  cuts: { name: string; rows: number; refused: string }[];
}

/** All records in one picture. */
export interface OverlayView {
  records: string[];
  axis: Shown & { name: string };
  loops: boolean;
  x: number[];
  quantities: (Shown & { name: string; lines: (number | null)[][] })[];
}

export interface ProposedRange extends Shown {
  name: string;
  low: number | null;
  high: number | null;
  start: number | null;
  scale: string | null;
  /** Start and bounds as they will be. */
  usual: [number, number, number];
  doc: string;
}

export interface ProposedModel {
  name: string;
  text: string;
  free: ProposedRange[];
  each: string[];
  starts: number;
}

export interface ProposalView {
  kind: string;
  said: string;
  refused: string;
  notes: string[];
  models: ProposedModel[];
}

export interface Quantity extends Shown {
  name: string;
  group: string;
  places: number;
  value: number;
  low: number | null;
  high: number | null;
  allowed: string;
  doc: string;
  origin: string;
}

export interface Drive {
  path: string;
  kind: string;
  waveform: string;
  column: string;
  what: string;
}

export interface ScenarioView {
  text: string;
  title: string;
  described?: string;
  refused: string;
  drives: Drive[];
  columns: Record<string, string>;
  records: string[];
  numbers: Quantity[];
  outputs: (Shown & { name: string; difference: Shown })[];
  notes?: string[];
  methods: Record<string, string>;
  losses: Record<string, string>;
}

export interface Parameter extends Shown {
  name: string;
  record: string | null;
  start: number;
  low: number;
  high: number;
  doc: string;
}

export interface Measured {
  name: string;
  times: number[];
  held: boolean[];
  outputs: (Shown & { name: string; long_name: string; measured: (number | null)[] })[];
}

export interface Problem {
  parameters: Parameter[];
  records: Measured[];
  noisy: string[];
  notes: string[];
  state: string;
}

export interface Note {
  problem?: Problem;
  stage?: string;
  cost?: number | null;
  simulations?: number;
  share?: number;
  seconds?: number;
  values?: Record<string, number>;
  /** Best so far: records, outputs, rows. */
  curves?: (number | null)[][][];
}

export interface Found extends Parameter {
  value: number;
  interval: [number, number] | null;
  mark: string;
}

export interface Score extends Shown {
  record: string;
  output: string;
  part: string;
  rms: number;
  fit_percent: number | null;
  maximum: number;
  maximum_at: number;
  bias: number;
}

export interface Compared extends Shown {
  record: string;
  output: string;
  long_name: string;
  times: number[];
  measured: (number | null)[];
  model: number[];
  held: boolean[];
  /** What a loop without times is drawn over. */
  axis: (Shown & { name: string; values: number[] }) | null;
}

/** What is to be thought of a fit, by the library's sentences. */
export interface Verdict {
  word: "good" | "usable" | "not usable";
  headline: string;
  reasons: string[];
  told: string[];
  untold: string[];
  next: string[];
}

export interface Outcome {
  title: string;
  verdict: Verdict;
  /** What was done to the logs, and assumed. */
  prepared: string[];
  command: string;
  reason: string;
  cost: number;
  simulations: number;
  jacobians: number;
  seconds: number;
  parameters: Found[];
  own: Record<string, number>;
  scores: Score[];
  determined: boolean;
  open: string[];
  uncertainty: string[];
  correlation: (number | null)[][];
  whiteness: string[];
  predictions: string[];
  warnings: string[];
  notes: string[];
  history: [number, number][];
  rows: Compared[];
  scenario: string;
  /** Key of what files are made from. */
  fit: string;
}
