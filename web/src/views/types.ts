// What martensite.app.views.page says of a scenario for the views of a run.

import type { Kind } from "../lib/types.ts";
import type { Table } from "./formulas.ts";

/** Formulas of an element, its limits and its source; numbers are rows of a table. */
export interface PortRows {
  temperature: number;
  stress: number;
  strain: number;
  /** Least and most that the source delivers. */
  reach: [least: number, most: number];
  source: string;
  unit: string;
  /** Set where the source prescribes the temperature. */
  prescribed: string | null;
  /** Column of the way along which it works. */
  way: string | null;
  /** Elongation per strain [m] of straight wires, where there is no such column. */
  length: number | null;
}

export interface LawWords {
  port: string;
  name: string;
  /** Knows tension only. */
  tension: boolean;
  /** Has an option for compression. */
  symmetric: boolean;
  /** Loops within each other that it remembers; 0 for all. */
  loops: number;
}

export interface Doubt extends Table {
  stress: number | null;
  sentence: string | null;
}

export interface LinesAt {
  port: string;
  x: string;
  y: string;
  structure: number;
  kind: "strips" | "detwinning" | "driven";
  driven: { bands: import("../lib/types.ts").Band[]; highest: number; sentence: string; values: Record<string, number> } | null;
}

export interface ShapeRows {
  name: string;
  kind: Kind;
  size: number;
  points: [x: number, y: number, z: number][];
  turn: number | null;
  port: string | null;
  mass: number;
  diameter?: number;
  coil?: number;
  coils?: number;
}

export interface Stroke {
  words: string;
  column: string;
  size: number;
  unit: string;
}

export interface Peak {
  words: string;
  columns: string[];
  least: boolean;
  size: number;
  zero: number;
  unit: string;
}

export interface Views {
  elements: Table & { ports: Record<string, PortRows>; supply: number | null; alone: boolean; prefixed: boolean };
  laws: LawWords[];
  doubts: Record<string, Doubt[]>;
  guard: { column: string; checks: Record<string, string[]>; limited: number; period: number } | null;
  key: { strokes: Stroke[]; peaks: Peak[] };
  /** Powers hold for a period. */
  held: boolean;
  /** Resonance of a beam with a motor [rad/s]; null for other mechanisms. */
  motor: Table & { resonance: number | null };
  lines: Table & { numbers: Record<string, Record<string, number>>; ports: LinesAt[] };
  scene: Table & { shapes: ShapeRows[]; ports: Record<string, { temperature: string; martensite_fraction: string; force: string; stress: string }>; newton: number; sentence: string };
}
