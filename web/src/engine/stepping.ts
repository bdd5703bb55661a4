// A model that goes on from its state: the march of a run over short spans of time, with drives held
// at levels and numbers that may change from span to span.

import { Refusal } from "../lib/refusal.ts";
import { hasFailed, planMarch, type Base } from "./accuracy.ts";
import { FINER, LOCAL } from "./constants.ts";
import type { Changes } from "./inputs.ts";
import { OUT_OF_ENVELOPE, type Marched, type RunModule } from "./march.ts";
import { describeExit, planBase, readInputs, type Inputs } from "./run.ts";
import type { Scenario } from "./types.ts";

/** Samples of the run that tells over which ranges the outputs move. */
const FEW = 51;

/** What came of a span. */
export interface Span {
  /** Ends of its parts [s], and outputs there, row by row. */
  times: Float64Array;
  rows: Float64Array;
  /** Why it was not taken; the model then stands where it stood. */
  said: string;
}

export class Stepping {
  /** How far the model is [s]. */
  time = 0;
  private state: Float64Array | null = null;
  private inputs: Inputs;
  private base: Base;
  private ranges: Float64Array;
  private first: number;

  constructor(
    private readonly scenario: Scenario,
    private readonly module: RunModule,
    changes: Changes,
  ) {
    this.inputs = readInputs(scenario, changes);
    const { duration, tolerance } = this.inputs;
    const times = Float64Array.from({ length: FEW }, (_, k) => (duration * k) / (FEW - 1));
    this.base = planBase(scenario, module, this.inputs, times);
    this.first = this.base.first;
    this.ranges = module.march(planMarch(this.base, this.local(tolerance))).ranges;
  }

  /** Error of a step that is allowed: that of the first of two runs which a run to a tolerance compares. */
  private local(tolerance: number): number {
    return this.base.step ? tolerance : (LOCAL[this.module.layout.order] * tolerance) / FINER;
  }

  /** Numbers from here on. */
  change(changes: Changes): void {
    const { scenario, module, base } = this;
    this.inputs = readInputs(scenario, changes);
    this.base = planBase(scenario, module, this.inputs, base.times);
  }

  /** Go on by a length [s] in so many parts, every drive at its level in SI. */
  go(length: number, parts: number, levels: number[]): Span {
    const { inputs, module } = this;
    const times = Float64Array.from({ length: parts + 1 }, (_, k) => (length * k) / parts);
    const drives = levels.map((level) => ({ segments: 1, tones: 0, table: Float64Array.of(0, level, 0, 0) }));
    const plan = { ...this.base, times, drives, first: Math.min(this.first, times[1]!), state: this.state };
    const found = module.march(planMarch(plan, this.local(inputs.tolerance), this.ranges, true));
    const said = this.tell(found, levels);
    if (said) return { times: new Float64Array(), rows: new Float64Array(), said };
    const skipped = this.state ? 1 : 0; // where it began is known
    const span = { times: times.slice(skipped).map((at) => this.time + at), rows: found.rows.slice(skipped * module.layout.outputs), said };
    this.state = found.state;
    this.ranges = this.ranges.map((known, k) => Math.max(known, found.ranges[k]!));
    this.first = Math.max(found.longest, this.base.first);
    this.time += length;
    return span;
  }

  /** Why a span cannot be taken; empty if it can. */
  private tell(found: Marched, levels: number[]): string {
    const { scenario, inputs } = this;
    if (levels.some((level) => !Number.isFinite(level))) return "A drive has no number.";
    if (found.status === OUT_OF_ENVELOPE) {
      const { place, value } = found;
      const exit = { place, value, low: inputs.low[place]!, high: inputs.high[place]!, time: this.time + found.time };
      return describeExit(scenario, exit);
    }
    return hasFailed(found.status) ? `The model cannot go on from here. ${scenario.statuses[found.status] ?? ""}` : "";
  }
}

/** A model at rest; throws the sentence where there is none. */
export function beginStepping(scenario: Scenario, module: RunModule, changes: Changes): Stepping {
  if (scenario.layout.march === "given") {
    throw new Refusal("A mechanism with a controller cannot run by hand. Open a scenario without a controller, such as “Wire and dead weight”.", "input", 400);
  }
  return new Stepping(scenario, module, changes);
}
