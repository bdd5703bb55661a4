// Levenberg–Marquardt in the box [0, 1]: least squares of residuals that come with a little noise, as those
// of runs with error control do.
//
//   (JᵀJ + λ D²) δ = -Jᵀr,   D = column norms of J
//
// J by central differences, whose steps are wide enough for the noise (a third root of it moves the residuals).
// Nothing is called converged that was not tested: at the end the derivatives ask for a step below a share of
// the standard errors (relative offset of Bates and Watts, 1981), and the last step that was taken was short.

import { decomposeSymmetric, dot, multiplyColumns, rms, type Matrix } from "./matrices.ts";

/** Residuals at a point, and whatever comes with them; null where there are none. */
export type Evaluate<Extra> = (shares: readonly number[]) => { residuals: Float64Array; extra: Extra } | null;

/** The best point so far, with what is known there. */
export interface Descent<Extra> {
  shares: number[];
  residuals: Float64Array;
  extra: Extra;
  /** Mean square of the residuals. */
  cost: number;
  /** Columns of derivatives by the shares; those of an earlier point while a search goes on; empty before the first. */
  jacobian: Float64Array[];
  runs: number;
  jacobians: number;
  /** Scatter of residuals that the evaluation itself makes. */
  noise: number;
  /** Step that the derivatives still ask for, in standard errors. */
  asked: number;
  /** How it ended; empty while it goes on. */
  reason: string;
  /** Runs and cost. */
  history: [number, number][];
}

export const CONVERGED = "converged";
export const BOUNDED = "stopped at bounds";
export const NOT_STATIONARY = "not at a stationary point";
export const IDLE = "nothing that is free changes what is compared; the fit did not move";
export const LIMITED = "ended by its limit of iterations";

const MOST = 60;
/** Step that is asked for, in standard errors, below which a point is stationary; and the one that a search stops at. */
const STATIONARY = 0.1;
const SETTLED = 0.01;
/** Last step of a search that has settled, as a share of a range, or in standard errors. */
const SHORT = 1e-4;
const PROBE = 1e-5;
const FIRST_STEP = 1e-3;
const [LEAST_STEP, MOST_STEP] = [1e-5, 1e-2];
const MOST_DAMPING = 1e9;
/** Residuals that are not larger than the scatter of evaluations by so much ask for steps of no meaning. */
const ROUGH = 30;
const AT_BOUND = 1e-9;
/** Singular value over the largest, of columns of equal norm, below which a direction is none. */
export const PRECISION = 1e-4;

export function descendSquares<Extra>(evaluate: Evaluate<Extra>, begin: readonly number[], tell: (now: Descent<Extra>) => void = () => {}, floor = 0): Descent<Extra> {
  return new Search(evaluate, tell, floor).run(begin);
}

class Search<Extra> {
  private runs = 0;
  private steps: number[] = [];
  private lastStep = Infinity;

  constructor(
    private readonly evaluate: Evaluate<Extra>,
    private readonly tell: (now: Descent<Extra>) => void,
    /** Residuals below it mean nothing: so far evaluations are off. */
    private readonly floor: number,
  ) {}

  private look(shares: readonly number[]): { residuals: Float64Array; extra: Extra } | null {
    this.runs++;
    const found = this.evaluate(shares);
    return found?.residuals.every(Number.isFinite) ? found : null;
  }

  run(begin: readonly number[]): Descent<Extra> {
    const shares = begin.map((x) => Math.min(1, Math.max(0, x)));
    const first = this.look(shares);
    if (!first) throw new Error("The run fails at the start values of the fit.");
    const now: Descent<Extra> = {
      ...first, shares, cost: rms(first.residuals) ** 2, jacobian: [], runs: 1, jacobians: 0, noise: 0, asked: Infinity, reason: "", history: [],
    };
    this.note(now);
    now.noise = this.measureNoise(now);
    let damping = 1e-3;
    for (let iteration = 0; iteration < MOST; iteration++) {
      now.jacobian = this.differentiate(now);
      now.jacobians++;
      const held = this.findHeld(now);
      now.asked = this.ask(now, held);
      this.report(now);
      if (now.asked <= SETTLED && this.lastStep <= SHORT) return this.end(now, held);
      const next = this.step(now, held, damping);
      if (next === null) {
        this.lastStep = 0; // nothing better is near
        return this.end(now, held);
      }
      damping = next;
      this.note(now);
    }
    now.reason = LIMITED;
    return now;
  }

  private note(now: Descent<Extra>): void {
    now.history.push([this.runs, now.cost]);
    this.report(now);
  }

  private report(now: Descent<Extra>): void {
    now.runs = this.runs;
    this.tell({ ...now, history: [...now.history] });
  }

  /** Scatter of residuals about a straight line along a way too short for anything else. */
  private measureNoise(now: Descent<Extra>): number {
    const away = (k: number): number[] => now.shares.map((x) => (x > 0.5 ? x - k * PROBE : x + k * PROBE));
    const [one, two] = [this.look(away(1)), this.look(away(2))];
    if (!one || !two) return 0;
    return rms(now.residuals.map((x, k) => x - 2 * one.residuals[k]! + two.residuals[k]!)) / Math.sqrt(6);
  }

  private differentiate(now: Descent<Extra>): Float64Array[] {
    return now.shares.map((share, j) => {
      const before = now.jacobian[j];
      const slope = before ? rms(before) : 0;
      const wanted = slope > 0 ? Math.cbrt(Math.max(now.noise, 1e-12)) / slope : FIRST_STEP;
      const step = (this.steps[j] = Math.min(MOST_STEP, Math.max(LEAST_STEP, wanted)));
      return this.differentiateOne(now, j, share, step);
    });
  }

  /** Central where both sides are inside and can be run, else to one side; nothing where neither can. */
  private differentiateOne(now: Descent<Extra>, j: number, share: number, step: number): Float64Array {
    const at = (x: number): Float64Array | null => (x < 0 || x > 1 ? null : (this.look(now.shares.map((own, k) => (k === j ? x : own)))?.residuals ?? null));
    const [high, low] = [at(share + step), at(share - step)];
    const [up, down] = [high ?? now.residuals, low ?? now.residuals];
    const width = (high ? step : 0) + (low ? step : 0);
    return now.residuals.map((_, k) => (width ? (up[k]! - down[k]!) / width : 0));
  }

  /** Numbers on a bound that the gradient holds there. */
  private findHeld(now: Descent<Extra>): boolean[] {
    return now.shares.map((share, j) => {
      const slope = dot(now.jacobian[j]!, now.residuals);
      return (share <= AT_BOUND && slope > 0) || (share >= 1 - AT_BOUND && slope < 0);
    });
  }

  /** Length of the step that the derivatives ask for, in standard errors. */
  private ask(now: Descent<Extra>, held: boolean[]): number {
    const columns = now.jacobian.filter((_, j) => !held[j]);
    const seen = projectResiduals(columns, now.residuals);
    const spare = now.residuals.length - seen.rank;
    if (!seen.rank || spare < 1) return 0;
    const scatter = Math.max(Math.sqrt((dot(now.residuals, now.residuals) - seen.square) / spare), ROUGH * now.noise, this.floor, 1e-14);
    return Math.sqrt(seen.square / seen.rank) / scatter;
  }

  /** A better point in place of the one before, and the damping after it; null where none is found. */
  private step(now: Descent<Extra>, held: boolean[], damping: number): number | null {
    const moving = now.shares.flatMap((_, j) => (held[j] || dot(now.jacobian[j]!, now.jacobian[j]!) === 0 ? [] : [j]));
    if (!moving.length) return null;
    const columns = moving.map((j) => now.jacobian[j]!);
    const norms = columns.map((one) => Math.sqrt(dot(one, one)));
    const scaled = multiplyColumns(columns).map((row, i) => row.map((x, j) => x / (norms[i]! * norms[j]!)));
    const gradient = columns.map((one, i) => dot(one, now.residuals) / norms[i]!);
    for (let grow = 2; damping <= MOST_DAMPING; grow *= 2) {
      const change = solveDamped(scaled, gradient, damping);
      const shares = [...now.shares];
      moving.forEach((j, i) => (shares[j] = Math.min(1, Math.max(0, shares[j]! - change[i]! / norms[i]!))));
      const moved = Math.max(...shares.map((x, j) => Math.abs(x - now.shares[j]!)));
      if (moved <= 1e-12) return null;
      const found = this.look(shares);
      const cost = found ? rms(found.residuals) ** 2 : Infinity;
      if (found && cost < now.cost) {
        const predicted = predictGain(now, shares);
        const gain = (now.cost - cost) / Math.max(predicted, 1e-300);
        this.lastStep = moved;
        Object.assign(now, found, { shares, cost });
        return Math.max(1e-12, damping * Math.max(1 / 3, 1 - (2 * Math.min(1, gain) - 1) ** 3));
      }
      damping *= grow;
    }
    return null;
  }

  private end(now: Descent<Extra>, held: boolean[]): Descent<Extra> {
    const still = now.asked <= STATIONARY && this.lastStep <= SHORT;
    const idle = now.jacobian.every((one) => dot(one, one) === 0);
    now.reason = idle ? IDLE : !still ? NOT_STATIONARY : held.some(Boolean) ? BOUNDED : CONVERGED;
    now.runs = this.runs;
    return now;
  }
}

/** Fall of the cost by the linear picture. */
function predictGain<Extra>(now: Descent<Extra>, shares: number[]): number {
  const moves = shares.map((x, j) => x - now.shares[j]!);
  const after = now.residuals.map((r, k) => now.jacobian.reduce((sum, column, j) => sum + column[k]! * moves[j]!, r));
  return now.cost - rms(after) ** 2;
}

/** Square of the part of residuals in the directions that columns determine, and how many those are. */
function projectResiduals(columns: Float64Array[], residuals: Float64Array): { square: number; rank: number } {
  const used = columns.filter((one) => dot(one, one) > 0);
  const norms = used.map((one) => Math.sqrt(dot(one, one)));
  const { values, vectors } = decomposeSymmetric(multiplyColumns(used).map((row, i) => row.map((x, j) => x / (norms[i]! * norms[j]!))));
  const gradient = used.map((one, i) => dot(one, residuals) / norms[i]!);
  const kept = values.flatMap((value, k) => (value > PRECISION ** 2 * values[0]! ? [dot(vectors[k]!, gradient) ** 2 / value] : []));
  return { square: kept.reduce((sum, x) => sum + x, 0), rank: kept.length };
}

/** (A + λ) x = b by the eigenvectors of A. */
function solveDamped(matrix: Matrix, right: number[], damping: number): number[] {
  const { values, vectors } = decomposeSymmetric(matrix);
  const found = right.map(() => 0);
  values.forEach((value, k) => {
    const along = dot(vectors[k]!, right) / (Math.max(value, 0) + damping);
    vectors[k]!.forEach((x, i) => (found[i]! += along * x));
  });
  return found;
}
