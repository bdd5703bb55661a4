// Residuals of runs of a scenario whose drives follow records.

import { FINER, hasFailed, LOCAL, planMarch } from "../engine/accuracy.ts";
import type { Changes } from "../engine/inputs.ts";
import type { Marched, Plan, RunModule } from "../engine/march.ts";
import { planBase, readInputs } from "../engine/run.ts";
import type { Scenario } from "../engine/types.ts";
import { Refusal } from "../lib/refusal.ts";
import { toShare, toValue, type Curves, type FittedRecord, type Problem } from "./problem.ts";

/** Tolerance of the runs of a fit, at most; that of the scenario where it is smaller. */
const TOLERANCE = 1e-4;
/** How often the steps of the first run are made finer, and from which on the tolerance is given up. */
const FINEST = 3;

export class FitModel {
  /** Runs that it has taken to choose its steps. */
  readonly runs: number;
  /** Largest change of a compared output, as a share of its range, when the steps of the start were made finer. */
  readonly apart: number;
  private readonly local: number[] = [];
  private readonly ranges: Float64Array[] = [];

  constructor(
    private readonly scenario: Scenario,
    private readonly module: RunModule,
    private readonly problem: Problem,
  ) {
    const start = this.list(problem.free.map((free) => toShare(free, free.start)));
    const chosen = problem.records.map((one) => this.choose(one, start));
    this.runs = chosen.reduce((sum, one) => sum + one.runs, 0);
    this.apart = Math.max(...chosen.map((one) => one.apart));
  }

  /** Numbers in SI at shares of the ranges, beside those that stay. */
  private list(shares: readonly number[]): Changes {
    const moved = this.problem.free.map((free, k) => [free.path, toValue(free, shares[k]!)] as const);
    return { ...this.problem.changes, ...Object.fromEntries(moved) };
  }

  private plan(record: FittedRecord, changes: Changes): Omit<Plan, "tolerance" | "ranges" | "parted" | "shortest"> & { inertial: number; own: number } {
    const inputs = readInputs(this.scenario, changes);
    const base = planBase(this.scenario, this.module, inputs, record.times);
    const drives = base.drives.map((drive, place) => record.drives.find(([own]) => own === place)?.[1] ?? drive);
    return { ...base, drives, own: inputs.tolerance };
  }

  /** Steps that are fine enough at the start; throws the sentence of a run that fails there. */
  private choose(record: FittedRecord, changes: Changes): { runs: number; apart: number } {
    const base = this.plan(record, changes);
    if (base.step) {
      this.local.push(base.own);
      this.ranges.push(new Float64Array(this.module.layout.judged));
      return { runs: 0, apart: 0 };
    }
    const tolerance = Math.min(base.own, TOLERANCE);
    let local = LOCAL[this.module.layout.order] * tolerance;
    let found = this.module.march(planMarch(base, local));
    let apart = Infinity;
    let runs = 1;
    for (let tries = 0; tries <= FINEST && apart > tolerance; tries++) {
      const before = found;
      local /= FINER;
      found = this.module.march(planMarch(base, local, found.ranges, true));
      runs++;
      apart = this.compare(record, before, found);
    }
    if (hasFailed(found.status)) throw new Refusal(`The run stops at ${found.time.toPrecision(4)} s with the numbers of the start. ${this.scenario.statuses[found.status] ?? ""}`, "solve", 400);
    this.local.push(local);
    this.ranges.push(found.ranges);
    return { runs, apart };
  }

  private compare(record: FittedRecord, one: Marched, other: Marched): number {
    const [before, after] = [this.pick(record, one), this.pick(record, other)];
    return Math.max(...record.compared.map(({ scale }, k) => before[k]!.reduce((most, x, row) => Math.max(most, Math.abs(x - after[k]![row]!) / scale), 0)));
  }

  private pick(record: FittedRecord, { rows }: Marched): Float64Array[] {
    const width = this.scenario.names.length;
    return record.compared.map(({ at }) => Float64Array.from(record.times, (_, row) => rows[row * width + at] ?? NaN));
  }

  private runRecord(record: FittedRecord, k: number, changes: Changes): Float64Array[] | null {
    const base = this.plan(record, changes);
    const found = this.module.march(planMarch(base, this.local[k]!, base.step ? null : this.ranges[k]!, !base.step));
    return hasFailed(found.status) || found.reached < record.times.length ? null : this.pick(record, found);
  }

  /** Residuals that count, over their scales, one output after the other; null where a run fails. */
  evaluate(shares: readonly number[]): { residuals: Float64Array; extra: Curves } | null {
    let changes: Changes;
    const curves: Curves = [];
    try {
      changes = this.list(shares);
      for (const [k, record] of this.problem.records.entries()) {
        const found = this.runRecord(record, k, changes);
        if (!found) return null;
        curves.push(found);
      }
    } catch (error) {
      if (error instanceof Refusal) return null; // numbers that contradict each other
      throw error;
    }
    const residuals = this.problem.records.flatMap(({ compared }, k) =>
      compared.flatMap(({ measured, scale, used }, j) => [...used.keys()].filter((row) => used[row]).map((row) => (curves[k]![j]![row]! - measured[row]!) / scale)),
    );
    return { residuals: Float64Array.from(residuals), extra: curves };
  }
}
