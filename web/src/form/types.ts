// Written by write_types.py from what Python declares; do not edit.

/** Declaration of one entry of a part. */
export interface EntryDescription {
  name: string;
  /** parameter, option, text or part. */
  declares: string;
  /** The name in words. */
  title: string;
  /** With `_` before its index; empty where the name is a word. */
  symbol: string;
  meaning: string;
  /** SI unit of a parameter. */
  unit: string | null;
  low: number | null;
  /** Bounds in SI; null for none. */
  high: number | null;
  allowed: string;
  /** Allowed names, for an option and for a part from a registry. */
  choices: string[];
  required: boolean;
  /** Default value; null for a required entry or an unlimited value. */
  default: unknown;
  /** Typical value as files write it, or null. Always an assumption, never data. */
  typical: unknown;
}

/** A registered part by its name. */
export interface NamedPart {
  name: string;
  summary: string;
}

/** All that is declared of a registered part. */
export interface PartDescription extends NamedPart {
  kind: string;
  description: string;
  cites: string[];
  parameters: EntryDescription[];
}

/** Origin of a value. */
export interface Origin {
  /** scenario, start, default, plant, none, law or material. */
  sort: string;
  words: string;
  /** Kind of a material value: datasheet, measured, fitted, assumed or recalled. */
  kind?: string;
  doubtful?: boolean;
  source?: string;
  cite?: string;
  where?: string;
  note?: string;
}

/** Value of the material for a parameter that the scenario sets. */
export interface MaterialValue extends Origin {
  text: string;
  value: number;
}

/** Ends of a slider in SI, whether it is logarithmic, and whether it goes in whole numbers. */
export interface SliderRange {
  low: number;
  high: number;
  log: boolean;
  whole: boolean;
}

/** Unit as it is written and as it is read, empty for none; shown = SI * factor + offset. */
export interface DisplayUnit {
  shown: string;
  label: string;
  factor: number;
  offset: number;
}

/** Common data of the controls of all entries, in addition to the declaration. */
export interface EntryControl extends EntryDescription {
  /** In the document. */
  path: string;
  origin: Origin;
  /** True if the value replaces a default or a value of the material. */
  changed: boolean;
}

/** A number; `unit` and `allowed` are those of its place. */
export interface NumberNode extends EntryControl, DisplayUnit {
  sort: "number";
  /** SI; null where there is none yet, or no limit. */
  value: number | null;
  unlimited: boolean;
  /** The default in words. */
  usual: string | null;
  slider: SliderRange | null;
  material: MaterialValue | null;
}

/** A choice between words. */
export interface OptionNode extends EntryControl {
  sort: "option";
  value: string;
}

/** The choice of a material. */
export interface MaterialNode extends EntryControl {
  sort: "material";
  value: string;
  materials: NamedPart[];
  about: string;
  limits: string;
}

/** A free text, or several. */
export interface TextNode extends EntryControl {
  sort: "text";
  value: string;
  several: boolean;
}

/** A list of numbers or quantities, or a whole number, as the document holds it. */
export interface RowNode extends EntryControl {
  sort: "row";
  value: string;
  several: boolean;
  /** True if the items carry units. */
  quantities: boolean;
}

/** The kind of a part, chosen from a registry. */
export interface KindChoice {
  path: string;
  value: string;
  registry: string;
  changed: boolean;
}

/** Controls that belong together. */
export interface GroupNode {
  sort: "group";
  path: string;
  title: string;
  meaning: string;
  note: string;
  kind: KindChoice | null;
  items: FormNode[];
}

export type SingleNode = NumberNode | OptionNode | MaterialNode | TextNode | RowNode;

export type FormNode = SingleNode | GroupNode;

/** The document, unless a kind needs numbers that nothing is known for. */
export interface MissingNumbers {
  /** Null if something is missing. */
  text: string | null;
  missing: SingleNode[];
  /** Missing entries, in a sentence; empty if complete. */
  refused: string;
}

/** A scenario with a control for all that it declares. */
export interface ScenarioForm extends MissingNumbers {
  title: string;
  sections: GroupNode[];
  registries: Record<string, NamedPart[]>;
  notes: string[];
  /** Paths of start values. */
  assumed: string[];
}
