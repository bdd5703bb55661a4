// A model that goes on from its state: the march of a run over short spans of time, with drives held
// at levels and numbers that may change from span to span.

import { formatGeneral } from "../views/formulas.ts";
import { hasFailed, planMarch, type Base } from "./accuracy.ts";
import { FINER, LOCAL } from "./constants.ts";
import type { Changes } from "./inputs.ts";
import { readSignal } from "./drives.ts";
import { OUT_OF_ENVELOPE, type Given, type Grid, type Marched, type RunModule } from "./march.ts";
import { describeExit, judgeGiven, planBase, readInputs, type Inputs } from "./run.ts";
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

class Stepping implements Steps {
  /** How far the model is [s]. */
  private time = 0;
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

/** A model that goes on from its state. */
export interface Steps {
  change(changes: Changes): void;
  go(length: number, parts: number, levels: number[]): Span;
}

/** A mechanism with a controller: it goes on by whole periods. */
class PeriodStepping implements Steps {
  private state: Float64Array | null = null;
  private inputs: Inputs;
  /** Periods so far, and time that is still to be run [s]. */
  private periods = 0;
  private due = 0;
  /** Signals of the document at every period, such as the noise of sensors. */
  private readonly own: Float64Array[];

  constructor(
    private readonly scenario: Scenario,
    private readonly module: RunModule,
    changes: Changes,
  ) {
    this.inputs = readInputs(scenario, changes);
    const interval = this.inputs.all[scenario.places.interval]!;
    const instants = Float64Array.from({ length: Math.floor(this.inputs.duration / interval + HAIR) + 1 }, (_, k) => (k + HAIR) * interval);
    this.own = scenario.places.drives.map((drive) => readSignal(scenario, drive, this.inputs.all, instants));
  }

  change(changes: Changes): void {
    this.inputs = readInputs(this.scenario, changes);
  }

  go(length: number, parts: number, levels: number[]): Span {
    const { inputs, module, scenario } = this;
    const interval = inputs.all[scenario.places.interval]!;
    const steps = Math.floor((this.due + length) / interval + HAIR);
    this.due = Math.max(this.due + length - steps * interval, 0);
    if (!steps) return { times: new Float64Array(), rows: new Float64Array(), said: "" };
    const found = module.marchGiven(inputs.parameters, this.grid(steps, Math.min(parts, steps), levels, interval), inputs.low, inputs.high, this.state);
    const said = tellGiven(scenario, found, this.periods * interval);
    if (said) return { times: new Float64Array(), rows: new Float64Array(), said };
    const ends = spread(steps, Math.min(parts, steps));
    const skipped = this.state ? 1 : 0; // where it began is known
    const times = Float64Array.from(ends.slice(skipped), (step) => (this.periods + step) * interval);
    this.state = found.state;
    this.periods += steps;
    return { times, rows: found.rows.slice(skipped * module.layout.outputs), said };
  }

  /** Steps with all drives at their levels; those without a level (NaN) repeat the signal of the document. */
  private grid(steps: number, parts: number, levels: number[], interval: number): Grid {
    const { scenario, periods, module, own } = this;
    const { inputs, places } = module.layout;
    const { drives: all } = scenario.places;
    const levelAt = (drive: number, step: number): number => (Number.isNaN(levels[drive]) ? own[drive]![(periods + step) % own[drive]!.length]! : levels[drive]!);
    const ends = spread(steps, parts);
    const drives = new Float64Array(Math.max(1, steps * inputs));
    for (let k = 0; k < steps; k++) all.forEach(({ ahead }, d) => (drives[k * inputs + places[d]!] = levelAt(d, k + (ahead ? 1 : 0))));
    return {
      first: Float64Array.from(all, (_, d) => levelAt(d, 0)),
      sampled: Float64Array.from(ends.slice(1).flatMap((step) => all.map((_, d) => levelAt(d, step)))),
      counts: Int32Array.from(ends.slice(1), (step, k) => step - ends[k]!),
      drives,
      lengths: new Float64Array(steps).fill(interval),
    };
  }
}

/** Whole numbers from 0 to an end, in so many parts of about equal size. */
const spread = (end: number, parts: number): number[] => Array.from({ length: parts + 1 }, (_, k) => Math.round((end * k) / parts));

const HAIR = 1e-9;

/** Why periods cannot be taken; empty if they can. */
function tellGiven(scenario: Scenario, found: Given, time: number): string {
  if (found.left < Infinity) return `At t = ${formatGeneral(time + found.left, 6)} s: ${scenario.statuses[OUT_OF_ENVELOPE] ?? ""}`;
  const status = judgeGiven(found);
  return hasFailed(status) ? `The model cannot go on from here. ${scenario.statuses[status] ?? ""}` : "";
}

/** A model at rest. */
export const beginStepping = (scenario: Scenario, module: RunModule, changes: Changes): Steps =>
  scenario.layout.march === "given" ? new PeriodStepping(scenario, module, changes) : new Stepping(scenario, module, changes);
