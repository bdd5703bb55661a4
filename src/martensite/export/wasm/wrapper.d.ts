/** $TITLE, as WebAssembly. All quantities in SI. */

export type Parameter = $PARAMETERS;
export type Signal = $SIGNALS;
export type Output = $OUTPUTS;
export type Status = "ok" | "long step" | "unsolved" | "out of range" | "not finite" | "bad input";

/** One number for all lanes, or one for each. */
export type Numbers = number | ArrayLike<number>;

export interface Quantity {
  readonly index: number;
  readonly unit: string;
  readonly words: string;
}
export interface ParameterQuantity extends Quantity {
  readonly value: number;
  readonly low: number;
  readonly high: number;
  /** Whether anything follows from it. */
  readonly used: boolean;
}
export interface SignalQuantity extends Quantity {
  /** Where it stands until it is given. */
  readonly first: number;
}

export const parameters: Readonly<Record<Parameter, ParameterQuantity>>;
export const signals: Readonly<Record<Signal, SignalQuantity>>;
export const outputs: Readonly<Record<Output, Quantity>>;
/** Length of every step [s] of a system in discrete time; 0 if a step may have any length. */
export const sampleTime: number;
export const STATUS: readonly Status[];

/** A call failed in a lane; that lane keeps its state, the others have gone on. */
export class ModelError extends Error {
  readonly status: Status;
  readonly lane: number;
}

/** Of `$NAME.wasm` beside the script, or of a URL, a response, or bytes. */
export function load(source?: string | URL | Response | BufferSource | WebAssembly.Module): Promise<Program>;

export interface Program {
  readonly module: WebAssembly.Module;
  /** A model in its own memory, at rest under its signals. */
  create(options?: {
    lanes?: number;
    parameters?: Partial<Record<Parameter, Numbers>>;
    signals?: Partial<Record<Signal, Numbers>>;
  }): Model;
}

export interface Run<Name extends Output> {
  /** End of the steps of the rows [s]. */
  time: Float64Array;
  /** Rows × lanes, lane by lane within a row; no numbers from where a lane has failed. */
  columns: Record<Name, Float64Array>;
  /** The worst of every lane. */
  status: Status[];
  /** That every lane has taken. */
  steps: Int32Array;
}

export interface Model {
  readonly lanes: number;
  /** Since the start [s]. */
  time: number;
  /** Set parameters: all of them, or none with an error. The model goes on from its state. */
  set(values: Partial<Record<Parameter, Numbers>>): void;
  get(name: Parameter, lane?: number): number;
  /** To rest under the signals, at time 0; those that are not given stay as they are. */
  start(signals?: Partial<Record<Signal, Numbers>>): void;
  /** Go on by dt [s] under constant signals. A `long step` is done, but coarse. */
  step(dt: number, signals?: Partial<Record<Signal, Numbers>>): "ok" | "long step";
  /** An output of a lane, of all lanes, or all outputs of a lane. */
  read(name: Output, lane?: number): number;
  column(name: Output): Float64Array;
  observe(lane?: number): Record<Output, number>;
  /** Many steps in one call, with a row after every `every`th and at the end. */
  run<Name extends Output = Output>(options: {
    dt: Numbers;
    /** By default as many as there are lengths. */
    steps?: number;
    /** A number, one a step, steps × lanes of them, or a function of the time at which a step begins. */
    signals?: Partial<Record<Signal, Numbers | ((time: number, lane: number) => number)>>;
    outputs?: readonly Name[];
    every?: number;
    /** `keep` returns what the other lanes did where one has failed. */
    failures?: "throw" | "keep";
  }): Run<Name>;
  /** All numbers of the model, to go back to. */
  save(): Float64Array;
  restore(saved: Float64Array): void;
}
