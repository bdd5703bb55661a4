// What the server tells of a form; see `build_form` of martensite.app.calls.form.

export interface Origin {
  from: string;
  words: string;
  kind?: string;
  doubtful?: boolean;
  source?: string;
  cite?: string;
  where?: string;
  note?: string;
}

interface Common {
  path: string;
  name: string;
  title: string;
  /** With `_` before its index; empty for none. */
  symbol: string;
  meaning: string;
  required: boolean;
  changed: boolean;
  origin: Origin;
}

export interface Slider {
  low: number;
  high: number;
  log: boolean;
  whole: boolean;
}

export interface Given extends Origin {
  text: string;
  value: number;
}

export interface NumberNode extends Common {
  sort: "number";
  /** SI; null where there is none yet, or no limit. */
  value: number | null;
  unit: string;
  /** Bounds, null for none, and the default [SI]. */
  low: number | null;
  high: number | null;
  default: number | null;
  /** Unit as it is written, and as it is read; empty for none. shown = SI * factor + offset. */
  shown: string;
  label: string;
  factor: number;
  offset: number;
  allowed: string;
  unlimited: boolean;
  /** The default in words. */
  usual: string | null;
  slider: Slider | null;
  /** What the material has for it, if the scenario gives it itself. */
  material: Given | null;
  own: boolean;
}

export interface OptionNode extends Common {
  sort: "option";
  value: string;
  choices: string[];
  default: string | null;
}

export interface Choice {
  name: string;
  summary: string;
}

export interface MaterialNode extends Common {
  sort: "material";
  value: string;
  choices: Choice[];
  about: string;
  limits: string;
}

export interface TextNode extends Common {
  sort: "text";
  value: string;
  several: boolean;
}

export interface RowNode extends Common {
  sort: "row";
  value: string;
  several: boolean;
  /** Whether its items carry units. */
  quantities: boolean;
}

export interface Kind {
  path: string;
  value: string;
  registry: string;
  /** What is meant where the scenario names none. */
  default: string | null;
  changed: boolean;
}

export interface GroupNode {
  sort: "group";
  path: string;
  title: string;
  meaning: string;
  note: string;
  kind: Kind | null;
  items: Node[];
}

export type Single = NumberNode | OptionNode | MaterialNode | TextNode | RowNode;
export type Node = Single | GroupNode;

export interface Form {
  text: string | null;
  title?: string;
  sections: GroupNode[];
  registries: Record<string, Choice[]>;
  notes: string[];
  assumed: string[];
  missing: Single[];
  refused?: string;
}
