// What the server tells of a sizing; see martensite.app.calls.sizing.

export interface Field {
  name: string;
  unit: string | null;
  meaning: string;
  allowed: string;
  /** Bounds in SI; null for none. */
  low: number | null;
  high: number | null;
  required: boolean;
  /** As one would type it; empty for none. */
  default: string;
  choices: string[];
  example: string;
}

export interface Form {
  fields: Field[];
  /** Fields that were named but that there are not. */
  unknown: string[];
  refused: Record<string, string>;
  contradiction: string;
  example: Fields;
}

/** What is typed, by the name of the field. */
export type Fields = Record<string, string>;

export interface Margin {
  name: string;
  share: number;
  used: string;
  limit: string;
  unit: string;
  /** Put to its limit by the sizing itself. */
  chosen: boolean;
}

export interface Candidate {
  size: string;
  alloy: string;
  feasible: boolean;
  reasons: string[];
  warnings: string[];
  cells: string[];
  headline: string;
  sentences: string[];
  doubts: string[];
  margins: Margin[];
  tightest: Margin;
  scenario: string | null;
  /** The same wire in a loop that a board can run. */
  loop: string | null;
  no_scenario: string;
  /** What a warmer day or more load would do to it; empty if it withstands both. */
  frail: string[];
  /** Wires side by side. */
  count: number;
  wiring: "single" | "series" | "parallel" | null;
  strand_resistance: number;
  /** What the supply gives during a pulse, in SI; null if it was not simulated. */
  drive: { current: number; voltage: number; power: number; energy: number } | null;
}

export interface Sizing {
  asked: Fields;
  columns: string[];
  candidates: Candidate[];
  /** Candidates that there are; fewer were judged if it was cancelled. */
  of: number;
}

export interface Checked {
  asked: Fields;
  conditions: string;
  columns: string[];
  rows: string[][];
  spread: string[];
  doubt: string;
}

export interface Note {
  done: number;
  of: number;
}

/** How wires do for a force and a stroke near the wish. */
export interface Cell {
  column: number;
  row: number;
  /** Wires that do, and those of them that withstand a warmer day and more load. */
  does: number;
  robust: number;
  best: { size: string; alloy: string; count: number } | null;
  /** Why the nearest does not; empty if one does. */
  reason: string;
}

export interface Mapped {
  asked: Fields;
  /** [N] */
  forces: number[];
  /** [m] */
  strokes: number[];
  cells: Cell[];
  of: number;
}

export interface MapNote extends Note {
  cell: Cell | null;
  forces: number[];
  strokes: number[];
}
