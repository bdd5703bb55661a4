// Runs to a tolerance: martensite/simulate/accuracy.py, for a run from home and at rest.

import { writeDecision } from "./sentences.ts";
import { UNSOLVED, type Marched, type Plan, type RunModule } from "./march.ts";
import type { Scenario } from "./types.ts";
import {
  COMMON, ERROR_SAFETY, FEW, FINER, FINEST, FLOOR, LEAST_ACCURACY, LOCAL, MOST_PASSES, ROUGHNESS, SHORTEST,
} from "./constants.ts";

/** A plan but its tolerance; what moves with inertia bounds the shortest step. */
export type Base = Omit<Plan, "tolerance" | "shortest" | "ranges" | "parted"> & { inertial: number };

export function planMarch(base: Base, tolerance: number, ranges: Float64Array | null = null, parted = false): Plan {
  const end = base.times[base.times.length - 1]!;
  const share = Math.min(FINEST, ROUGHNESS / Math.max(tolerance, ROUGHNESS));
  return { ...base, tolerance, ranges, parted, shortest: Math.max(SHORTEST * end, base.inertial * share) };
}

/** The last run to a tolerance, a bound on its error as a share of ranges, and a warning of a doubtful decision. */
export function marchTo(module: RunModule, scenario: Scenario, base: Base, tolerance: number): [Marched, number, string] {
  const compared = chooseSamples(base.times.length);
  let local = LOCAL[module.layout.order] * tolerance;
  const some = { ...base, times: Float64Array.from(compared, (k) => base.times[k]!) };
  let found = module.march(planMarch(some, local));
  let rows = pickJudged(scenario, found, null);
  let bound = Infinity;
  for (let run = 0; run < MOST_PASSES; run++) {
    local /= FINER;
    const ranges = run || !module.layout.shares ? found.ranges : null;
    found = module.march({ ...planMarch(base, local, ranges, true), recorded: true });
    const before = rows;
    rows = pickJudged(scenario, found, compared);
    bound = boundError(scenario, found, before, rows);
    if (bound <= tolerance) break;
  }
  const floor = (module.layout.shares ? 2 * FLOOR : FLOOR) * tolerance;
  const accuracy = Math.max(bound, module.layout.shares ? floor : Math.min(bound + COMMON * tolerance, floor));
  const [error, effect] = findDoubt(scenario, found, Math.max(bound, floor));
  return effect ? [found, Math.max(accuracy, effect), describeDecision(scenario, found.decision, error)] : [found, accuracy, ""];
}

/** Error [K] and effect, as a share of the range, of a decision that the error of the run may change; else 0. */
function findDoubt({ layout, judged }: Scenario, { decision, ranges }: Marched, accuracy: number): [number, number] {
  const [margin = Infinity, , change = 0, place = -1] = decision;
  const fork = layout.forks[place];
  if (!fork) return [0, 0];
  const [fraction, temperature, stress, weight] = fork;
  const span = (k: number): number => Math.max(ranges[k]!, judged[k]![1]);
  const error = accuracy * (span(temperature) + layout.perStress * span(stress));
  const effect = (weight * change) / span(fraction);
  return Math.abs(margin) <= error && effect > accuracy ? [error, effect] : [0, 0];
}

function describeDecision({ layout, names, judged }: Scenario, decision: number[], error: number): string {
  const [margin = 0, time = 0, change = 0, place = 0, branch = 0] = decision;
  const name = names[judged[layout.forks[place]![0]]![0]]!;
  return writeDecision(time, name.slice(0, Math.max(0, name.lastIndexOf("."))), margin, branch, error, change);
}

/** Samples that are compared: not many more than `FEW`, both ends among them. */
export function chooseSamples(count: number): number[] {
  const every = Math.max(1, Math.ceil((count - 1) / (FEW - 1)));
  const found: number[] = [];
  for (let k = 0; k < count; k += every) found.push(k);
  if (found[found.length - 1] !== count - 1) found.push(count - 1);
  return found;
}

/** What is judged, at samples that were reached. */
function pickJudged(scenario: Scenario, found: Marched, samples: number[] | null): number[][] {
  const width = scenario.names.length;
  const known = samples?.filter((k) => k < found.reached) ?? [...Array(found.reached).keys()];
  return known.map((k) => scenario.judged.map(([output]) => found.rows[k * width + output]!));
}

/** The larger of two numbers; samples at which a run was outside of its envelope have none, and do not count. */
const larger = (one: number, other: number): number => (other > one ? other : one);

function boundError(scenario: Scenario, found: Marched, before: number[][], after: number[][]): number {
  const count = Math.min(before.length, after.length);
  let worst = 0;
  scenario.judged.forEach(([, least], k) => {
    let apart = count ? -Infinity : Infinity;
    for (let row = 0; row < count; row++) apart = larger(apart, Math.abs(before[row]![k]! - after[row]![k]!));
    worst = larger(worst, apart / Math.max(found.ranges[k]!, least));
  });
  const heat = scenario.judged.length ? Math.max(found.ranges[0]!, scenario.judged[0]![1]) : 1;
  const total = Math.max(ERROR_SAFETY * worst + found.ripple / heat, ERROR_SAFETY * found.residual, LEAST_ACCURACY);
  return Number.isFinite(total) ? total : Infinity;
}

export const hasFailed = (status: number): boolean => status >= UNSOLVED;
