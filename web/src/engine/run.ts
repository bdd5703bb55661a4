// A run of a scenario of the page: inputs from its controls, the march, and what is said of it.

import { Refusal } from "../lib/refusal.ts";
import { hasFailed, marchTo, planMarch, type Base } from "./accuracy.ts";
import { COARSE, JUST_AFTER, LEAST_HEAT, LEAST_WORK, SOLVED } from "./constants.ts";
import { readSignal, tableOf } from "./drives.ts";
import { listSaid, predictInputs, type Changes } from "./inputs.ts";
import { writeBound, writeEnd, writeFailure, writeMissed, writeResidual, writeStop } from "./sentences.ts";
import { listTrackRows, weighTrapezoids } from "./track.ts";
import { LONG_STEP, MOST_STEPS, NOT_FINITE, OK, OUT_OF_ENVELOPE, TooLong, UNSOLVED, type Given, type Grid, type Marched, type RunModule } from "./march.ts";
import { formatGeneral } from "../views/formulas.ts";
import type { RunCore, Scenario, Track } from "./types.ts";

const ENDS_ELSEWHERE = 1e-6;
/** Share of a range that is seen in a curve. */
const VISIBLE = 1e-3;
/** Steps of a run in discrete time up to which its outputs are kept at the end of each. */
const MOST_ROWS = 200_000;

/** What a run needs, from the inputs. */
export interface Inputs {
  parameters: Float64Array;
  duration: number;
  tolerance: number;
  samples: number;
  low: Float64Array;
  high: Float64Array;
  all: Float64Array;
}

export function runScenario(scenario: Scenario, module: RunModule, changes: Changes, text: string): RunCore {
  const begun = performance.now();
  const { layout } = scenario;
  const inputs = readInputs(scenario, changes);
  const found = layout.march === "given" ? marchGiven(scenario, module, inputs) : march(scenario, module, inputs);
  const seen = scenario.magnified > VISIBLE;
  return {
    name: scenario.name,
    text,
    changes,
    ...found,
    parameters: Object.fromEntries(scenario.parameters.map((path, k) => [path, inputs.parameters[k]!])),
    duration: inputs.duration,
    tolerance: inputs.tolerance,
    samples: inputs.samples,
    seconds: (performance.now() - begun) / 1000,
    warnings: [...found.warnings, ...(seen ? scenario.differs : [])],
    cautions: [...scenario.cautions, ...listSaid(scenario, changes), ...(seen ? [] : scenario.differs)],
  };
}

export function readInputs(scenario: Scenario, changes: Changes): Inputs {
  const all = predictInputs(scenario, changes);
  const { places, layout } = scenario;
  return {
    parameters: all.slice(0, layout.parameters),
    duration: all[places.duration]!,
    tolerance: all[places.tolerance]!,
    samples: countSamples(all[places.samples]!, all[places.duration]!, all[places.interval]!),
    low: all.slice(places.low, places.low + layout.envelope),
    high: all.slice(places.high, places.high + layout.envelope),
    all,
  };
}

/** Samples of a run; those of a bench are its periods. */
const countSamples = (asked: number, duration: number, interval: number): number =>
  Number.isFinite(asked) ? Math.round(asked) : Math.max(2, Math.floor(duration / interval + 1e-6) + 1);

type Found = Omit<RunCore, "name" | "text" | "changes" | "parameters" | "duration" | "tolerance" | "samples" | "seconds" | "cautions">;

function march(scenario: Scenario, module: RunModule, inputs: Inputs): Found {
  const times = Float64Array.from({ length: inputs.samples }, (_, k) => (inputs.duration * k) / (inputs.samples - 1));
  const base = planBase(scenario, module, inputs, times);
  const follow = (found: Marched): Track => {
    const rows = listTrackRows(found.record, scenario.layout.recorded, base.drives, scenario.layout.order === 5);
    return trackOf(scenario, inputs, rows, module.observe(inputs.parameters, rows), found.status === OUT_OF_ENVELOPE);
  };
  try {
    if (base.step) return describeMarch(scenario, inputs, times, module.march({ ...planMarch(base, inputs.tolerance), recorded: true }), null, follow);
    const [found, accuracy, doubt] = marchTo(module, scenario, base, inputs.tolerance);
    return describeMarch(scenario, inputs, times, found, accuracy, follow, doubt);
  } catch (error) {
    if (!(error instanceof TooLong)) throw error;
    throw new Refusal(`This run needs more than ${MOST_STEPS.toLocaleString("en")} steps. Make it shorter, or its tolerance larger.`, "input", 400);
  }
}

/** A run with the drives of the document. */
export function planBase({ places }: Scenario, module: RunModule, inputs: Inputs, times: Float64Array): Base {
  const step = inputs.all[places.step]!;
  const longest = Math.min(module.findLongestStep(inputs.parameters), inputs.all[places.mechanism]!);
  return {
    parameters: inputs.parameters,
    times,
    first: Math.min(longest, times[1]! - times[0]!),
    low: inputs.low,
    high: inputs.high,
    step: Number.isFinite(step) ? step : 0,
    inertial: inputs.all[places.inertial]!,
    drives: places.drives.map((drive) => tableOf(drive, inputs.all)),
  };
}

function describeMarch(scenario: Scenario, inputs: Inputs, times: Float64Array, found: Marched, accuracy: number | null, follow: (found: Marched) => Track, doubt = ""): Found {
  refuseFailure(scenario, found.status, found.time);
  const leaves = found.status === OUT_OF_ENVELOPE;
  const reached = leaves ? countInside(scenario, inputs, found.rows, found.reached) : found.reached;
  const exit = leaves
    ? { place: found.place, value: found.value, low: inputs.low[found.place]!, high: inputs.high[found.place]!, time: found.time }
    : null;
  const warnings = accuracy === null ? [] : listUnbalanced(scenario, inputs, found);
  if (exit) warnings.push(describeExit(scenario, exit));
  if (found.status === LONG_STEP) warnings.push(`Warning: ${scenario.statuses[LONG_STEP]}`);
  if (doubt) warnings.push(doubt);
  else if (accuracy !== null && accuracy > inputs.tolerance && !hasFailed(found.status)) {
    warnings.push(writeMissed(inputs.tolerance, found.steps, accuracy));
  }
  return {
    ...spread(scenario, found.rows, times, reached),
    track: follow(found),
    status: leaves ? "OUT_OF_ENVELOPE" : found.status === LONG_STEP ? "LONG_STEP" : "OK",
    statusTime: found.status === OK ? null : found.time,
    accuracy,
    steps: found.steps,
    rejected: found.rejected,
    step: found.longest,
    ripple: found.ripple,
    residual: found.residual,
    putIn: found.putIn,
    lost: found.lost,
    accounts: [...found.accounts],
    exit,
    warnings,
  };
}

function marchGiven(scenario: Scenario, module: RunModule, inputs: Inputs): Found {
  const { places } = scenario;
  const interval = inputs.all[places.interval]!;
  const { grid, rows, samples } = gridOf(scenario, inputs, interval);
  const times = samples.map((k) => k * interval);
  const found = module.marchGiven(inputs.parameters, grid, inputs.low, inputs.high);
  const residual = found.worst[0] ?? 0;
  const status = judgeGiven(found);
  if (found.left < Infinity) {
    throw new Refusal(writeStop(found.left, scenario.statuses[OUT_OF_ENVELOPE]!), "solve", 400);
  }
  refuseFailure(scenario, status, NaN);
  const warnings = status === LONG_STEP ? [`Warning: ${scenario.statuses[LONG_STEP]}`] : [];
  const end = times[times.length - 1]!;
  if (Math.abs(end - inputs.duration) > ENDS_ELSEWHERE * inputs.duration) {
    warnings.push(writeEnd(end, inputs.duration, interval));
  }
  return {
    ...spread(scenario, rows === samples ? found.rows : pickOutputs(found.rows, scenario.names.length, samples), times, times.length),
    track: rows === samples ? null : trackOf(scenario, inputs, trackSteps(rows, interval), found.rows, false),
    status: status === LONG_STEP ? "LONG_STEP" : "OK",
    statusTime: null,
    accuracy: null,
    steps: grid.lengths.length,
    rejected: 0,
    step: interval,
    ripple: 0,
    residual,
    putIn: 0,
    lost: 0,
    accounts: [],
    exit: null,
    warnings,
  };
}

/** Status of steps in discrete time. */
export function judgeGiven({ rows, worst }: Given): number {
  const [residual = 0, crossing = 0] = worst;
  if (!rows.every(Number.isFinite) || !Number.isFinite(residual)) return NOT_FINITE;
  return residual > SOLVED ? UNSOLVED : crossing > COARSE ? LONG_STEP : OK;
}

function trackSteps(rows: Float64Array, interval: number): { times: Float64Array; weights: Float64Array } {
  const times = rows.map((k) => k * interval);
  return { times, weights: weighTrapezoids(times) };
}

const pickOutputs = (rows: Float64Array, width: number, places: Float64Array): Float64Array => {
  const found = new Float64Array(width * places.length);
  places.forEach((k, i) => found.set(rows.subarray(width * k, width * (k + 1)), width * i));
  return found;
};

/** The grid of a system in discrete time (`grid_of_samples`): steps at which it has a row, and those that are samples. */
function gridOf(scenario: Scenario, inputs: Inputs, interval: number): { grid: Grid; rows: Float64Array; samples: Float64Array } {
  const { layout, places } = scenario;
  const steps = Math.floor(inputs.duration / interval + 1e-9);
  if (!(steps >= 1 && steps <= MOST_STEPS)) {
    throw new Refusal(`A run of ${formatGeneral(inputs.duration, 6)} s in samples of ${formatGeneral(interval, 6)} s has ${steps} steps.`, "input", 400);
  }
  const pieces = Math.min(inputs.samples - 1, steps);
  const samples = Float64Array.from({ length: pieces + 1 }, (_, i) => roundHalfEven((steps * i) / pieces));
  const rows = steps <= MOST_ROWS ? Float64Array.from({ length: steps + 1 }, (_, k) => k) : samples;
  const instants = Float64Array.from({ length: steps + 1 }, (_, k) => (k + JUST_AFTER) * interval);
  const signals = places.drives.map((drive) => readSignal(scenario, drive, inputs.all, instants));
  const count = signals.length;
  const sampled = new Float64Array(rows.length * count);
  rows.forEach((k, i) => signals.forEach((one, d) => (sampled[i * count + d] = one[k]!)));
  const drives = new Float64Array(Math.max(1, steps * layout.inputs));
  for (let k = 0; k < steps; k++) {
    signals.forEach((one, d) => (drives[k * layout.inputs + layout.places[d]!] = one[k + (places.drives[d]!.ahead ? 1 : 0)]!));
  }
  const grid = {
    first: sampled.slice(0, count),
    sampled: sampled.slice(count),
    counts: Int32Array.from({ length: rows.length - 1 }, (_, i) => rows[i + 1]! - rows[i]!),
    drives,
    lengths: new Float64Array(steps).fill(interval),
  };
  return { grid, rows, samples };
}

function roundHalfEven(x: number): number {
  const low = Math.floor(x);
  return x - low === 0.5 ? low + (low % 2) : Math.round(x);
}

function refuseFailure(scenario: Scenario, status: number, time: number): void {
  if (!hasFailed(status) || status === OUT_OF_ENVELOPE) return;
  throw new Refusal(writeFailure(Number.isNaN(time) ? null : time, scenario.statuses[status] ?? ""), "solve", 400);
}

/** Rows before the first one that is outside of the envelope; the first of all stays. */
function countInside(scenario: Scenario, inputs: Inputs, rows: Float64Array, reached: number): number {
  const width = scenario.names.length;
  for (let k = 1; k < reached; k++) {
    const inside = scenario.envelope.every(({ output }, i) => {
      const value = rows[k * width + output]!;
      return inputs.low[i]! <= value && value <= inputs.high[i]!;
    });
    if (!inside) return k;
  }
  return reached;
}

/** The rows of a track from their outputs; of a run that leaves the envelope those before it is outside. */
function trackOf(scenario: Scenario, inputs: Inputs, rows: { times: ArrayLike<number>; weights: ArrayLike<number> }, outputs: Float64Array, leaves: boolean): Track {
  const count = leaves ? countInside(scenario, inputs, outputs, rows.times.length) : rows.times.length;
  const { times, columns } = spread(scenario, outputs, Float64Array.from(rows.times), count);
  return { times, columns, weights: Float64Array.from(rows.weights).subarray(0, count) };
}

/** Columns and profiles, by name. */
function spread(scenario: Scenario, rows: Float64Array, times: Float64Array, reached: number): Pick<RunCore, "times" | "columns" | "profiles"> {
  const width = scenario.names.length;
  const columns: Record<string, Float64Array> = {};
  const profiles: Record<string, Float64Array> = {};
  scenario.names.forEach((name, k) => {
    const own = new Float64Array(reached);
    for (let row = 0; row < reached; row++) own[row] = rows[row * width + k]!;
    (k < scenario.columns ? columns : profiles)[name] = own;
  });
  return { times: times.slice(0, reached), columns, profiles };
}

export function describeExit(scenario: Scenario, exit: NonNullable<RunCore["exit"]>): string {
  const bound = scenario.envelope[exit.place]!;
  const shown = (x: number): string => `${formatGeneral(x * bound.factor + bound.offset, 5)} ${bound.display_unit}`;
  const reason = bound.name === "hottest" && exit.value <= 0 ? "absolute zero" : bound.reason;
  const limit = exit.value > 0 ? exit.high : exit.low;
  return writeStop(exit.time, writeBound(bound.words, "", exit.value, limit, `the limit of ${shown(limit)}`, shown(exit.value), reason));
}

/** Sentences on heat and work that are not accounted for; see `martensite/simulate/ledger.py`. */
function listUnbalanced(scenario: Scenario, inputs: Inputs, found: Marched): string[] {
  const own: Record<string, number> = {};
  scenario.accounts.forEach((name, k) => (own[name] = found.accounts[k]!));
  const sum = (...names: string[]): number => names.reduce((total, name) => total + (own[name] ?? 0), 0);
  const said: string[] = [];
  const tell = (words: string, missing: number, most: number, least: number): void => {
    const residual = missing / most;
    if (most > least && !(residual <= inputs.tolerance)) {
      said.push(writeResidual(residual, words, inputs.tolerance));
    }
  };
  if (scenario.balances.heat) {
    const stored = sum("sensible", "latent");
    const most = Math.max(Math.abs(found.putIn), Math.abs(found.lost), Math.abs(stored), sum("exchanged_heat"));
    tell("heat", Math.abs(found.putIn - found.lost - stored), most, LEAST_HEAT);
  }
  if (scenario.balances.work) {
    const held = sum("springs", "gravity", "kinetic", "magnetic");
    const spent = sum("dissipated");
    const most = Math.max(sum("exchanged"), Math.abs(held), Math.abs(spent));
    tell("work", Math.abs(sum("work") - held - spent - sum("outside")), most, LEAST_WORK);
  }
  return said;
}
