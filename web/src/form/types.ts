// Written by write_types.py from declarations in Python; do not edit.

/** Declaration of an entry of a part. */
export interface EntryDescription {
  name: string;
  /** parameter, option, text or part. */
  declares: string;
  /** Name in words. */
  title: string;
  /** Symbol with `_` before its index; empty for a word. */
  symbol: string;
  meaning: string;
  /** SI unit of a parameter. */
  unit: string | null;
  low: number | null;
  /** Bounds in SI; null for none. */
  high: number | null;
  allowed: string;
  /** Allowed names of an option or registered part. */
  choices: string[];
  required: boolean;
  /** Default value; null for a required entry or an unlimited value. */
  default: unknown;
  /** Assumed typical value as files write it, or null. */
  typical: unknown;
}

/** Name and summary of a registered part. */
export interface NamedPart {
  name: string;
  summary: string;
}

/** Full declaration of a registered part. */
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

/** Ends of a slider in SI, whether it is logarithmic, and whether it is an integer. */
export interface SliderRange {
  low: number;
  high: number;
  log: boolean;
  whole: boolean;
}

/** Spelling and label of a unit, empty without one; displayed number = SI * factor + offset. */
export interface DisplayUnit {
  display_unit: string;
  label: string;
  factor: number;
  offset: number;
}

/** Common data of all controls, in addition to the declaration. */
export interface EntryControl extends EntryDescription {
  /** Path in the document. */
  path: string;
  origin: Origin;
  /** True if the value replaces a default or a value of the material. */
  changed: boolean;
}

/** A number, with `unit` and `allowed` of its place. */
export interface NumberNode extends EntryControl, DisplayUnit {
  sort: "number";
  /** SI; null if missing or without limit. */
  value: number | null;
  unlimited: boolean;
  /** Default as text. */
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

/** One or several texts. */
export interface TextNode extends EntryControl {
  sort: "text";
  value: string;
  several: boolean;
}

/** A list of numbers or quantities, or an integer. */
export interface RowNode extends EntryControl {
  sort: "row";
  value: string;
  several: boolean;
  /** True if the items have units. */
  quantities: boolean;
}

/** The kind of a part, chosen from a registry. */
export interface KindChoice {
  path: string;
  value: string;
  registry: string;
  changed: boolean;
}

/** A group of controls. */
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

/** The document, unless a kind needs unknown values. */
export interface MissingNumbers {
  /** Null if values are missing. */
  text: string | null;
  missing: SingleNode[];
  /** Sentence on missing entries; empty if complete. */
  refused: string;
}

/** A scenario with a control for each entry. */
export interface ScenarioForm extends MissingNumbers {
  title: string;
  sections: GroupNode[];
  registries: Record<string, NamedPart[]>;
  notes: string[];
  /** Paths of start values. */
  assumed: string[];
}
