// What the server tells of a run; see martensite.app.calls.scenarios.

export interface Output {
  unit: string;
  /** Unit it is shown in; empty for none. displayed number = SI * factor + offset. */
  display_unit: string;
  factor: number;
  offset: number;
  long_name: string;
  symbol: string;
}

export interface Alarm {
  kind: string;
  quantity: string;
  unit: string;
  worst: number;
  limit: number;
  excess: number;
  first: number;
  duration: number;
  worst_time: number;
  sentence: string;
  port: string;
  /** The column that was judged, and how it is shown. */
  column: string;
  /** Key of the panel in which it stands. */
  panel: string;
  how: Output;
  /** Times between which it occurs [s]. */
  spans: [begin: number, end: number][];
  /** The limit, if it is a level of the column. */
  level: number | null;
}

/** Columns that are drawn together over time, by port; those of no port under "". */
export interface Panel {
  key: string;
  title: string;
  usual: boolean;
  includes: number[];
  ports: Record<string, string[]>;
}

/** Columns [x, y] by port. */
export interface Loop {
  key: string;
  ports: Record<string, [x: string, y: string]>;
}

/** Sense of a part of a path (1 heated, -1 cooled, 0 neither), first and last row. */
export type Stretch = [sense: number, first: number, last: number];

export interface Line {
  name: string;
  temperature: number[];
  stress: number[];
}

export interface Band {
  process: string;
  start: Line;
  finish: Line;
}

export interface Phase {
  diagrams: { bands: Band[]; highest: number; sentence: string }[];
  ports: Record<string, { diagram: number; x: string; y: string }>;
}

export interface Course {
  key: string;
  symbol: string;
  long_name: string;
  display_unit: string;
  factor: number;
  values: number[];
}

export interface Energy {
  courses: Course[];
  efficiency: (number | null)[] | null;
  /** What is not known, and why. */
  sentence: string;
}

/** What is said of a run, and how much it is, in words. */
export type KeyResult = [name: string, value: string];

/** Kinds of shapes; see martensite.actuators.mechanisms.drawing. */
export type Kind =
  | "ground" | "wall" | "link" | "phalanx" | "fingertip" | "beam" | "bracket" | "joint" | "wire" | "spring" | "tether" | "force" | "weight"
  | "slider" | "pulley" | "cylinder" | "motor" | "plate" | "palm" | "rotor" | "object";

export interface Shape {
  name: string;
  kind: Kind;
  /** Radius or half thickness [m]. */
  size: number;
  /** Number of points. */
  count: number;
  /** x, y, z of every point in quanta, if it stands still. */
  still: number[] | null;
  /** Of an element: its port, diameters of its wire and its coil [m] (0: none), turns of the coil. */
  port?: string;
  diameter?: number;
  coil?: number;
  coils?: number;
  /** Of a weight, where it is known [kg]. */
  mass?: number;
}

/** The mechanism in space; z is up. */
export interface SceneData {
  shapes: Shape[];
  times: number[];
  /** Length of a unit of the coordinates [m]. */
  quantum: number;
  /** Length of an arrow of a force [m/N]. */
  newton: number;
  /** By time: x, y, z of all points of the shapes that move, in quanta. */
  frames: number[][];
  /** By time: angles of pulleys and rotors [rad], in their order. */
  turns: number[][];
  /** Corners of the box that holds the whole motion [m]. */
  low: [number, number, number];
  high: [number, number, number];
  /** Names of columns by port, and by time whether the element hangs slack. */
  ports: Record<string, { temperature: string; martensite_fraction: string; force: string; stress: string; slack: number[] }>;
  /** Why nothing is drawn. */
  sentence?: string;
}

/** What the server and a run in the page tell alike. */
export interface RunTold {
  text: string;
  title: string;
  described: string;
  status: string;
  accuracy: number | null;
  /** Samples of the run; its rows are more, for they hold accepted steps as well. */
  samples: number;
  steps: number;
  step: number;
  stroke: number;
  coordinate: string;
  ports: string[];
  cautions: string[];
  warnings: string[];
  alarms: Alarm[];
  runtime: string;
  seconds: number;
  times: number[];
  columns: Record<string, number[]>;
  /** Lowest and highest value of every column in the run. */
  ends: Record<string, [low: number, high: number]>;
  outputs: Record<string, Output>;
  traces: Panel[];
  loops: Loop[];
  energy: Energy;
  key: KeyResult[];
}

/** What the server answers: the page makes the rest by formulas of these parameters. */
export interface RunAnswer extends RunTold {
  parameters: Record<string, number | string>;
  views: unknown;
}

export interface Run extends RunTold {
  stretches: Record<string, Stretch[]>;
  phase: Phase;
  scene: SceneData;
  /** Of a beam with a motor [rad/s]; else null. */
  resonance: number | null;
  /** Set where it was recorded by hand, and the document does not bring it back. */
  only?: true;
}
