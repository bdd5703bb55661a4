// Runs the C of martensite/simulate in WebAssembly: marching.c with adaptive.c or fixed.c, and
// given_steps.c. What it is told lies in the memory of the module, as `_March` of
// marching_native.py says, with words and pointers of 4 bytes.

import { recordWidth, type TrackRows } from "./track.ts";
import type { Layout } from "./types.ts";

/** Segments (start, level, slope, bend) and tones (amplitude, rate, phase) of a drive, column by column. */
export interface DriveTable {
  segments: number;
  tones: number;
  table: Float64Array;
}

export interface Plan {
  parameters: Float64Array;
  times: Float64Array;
  tolerance: number;
  first: number;
  low: Float64Array;
  high: Float64Array;
  /** Of what is judged; null where not known. */
  ranges: Float64Array | null;
  /** Longest of equal steps; 0 for steps by tolerance. */
  step: number;
  shortest: number;
  parted: boolean;
  drives: DriveTable[];
  /** State from which the run goes on; it begins at rest where there is none. */
  state?: Float64Array | null;
  /** Whether accepted steps are recorded. */
  recorded?: boolean;
}

export interface Marched {
  /** Outputs, row by row, of the samples that were reached. */
  rows: Float64Array;
  reached: number;
  ranges: Float64Array;
  status: number;
  time: number;
  place: number;
  value: number;
  steps: number;
  rejected: number;
  longest: number;
  ripple: number;
  residual: number;
  putIn: number;
  lost: number;
  accounts: Float64Array;
  /** Closest decision about a forgotten branch: margin [K], time [s], change, fork (-1 without one), branch. */
  decision: number[];
  /** At the end. */
  state: Float64Array;
  /** Pieces of accepted steps, in the layout of martensite/simulate/track.py; empty if they were not recorded. */
  record: Float64Array;
}

/** A grid of a system in discrete time; see `TimeGrid`. */
export interface Grid {
  first: Float64Array;
  sampled: Float64Array;
  counts: Int32Array;
  drives: Float64Array;
  lengths: Float64Array;
}

export interface Given {
  rows: Float64Array;
  worst: Float64Array;
  left: number;
  /** At the end. */
  state: Float64Array;
}

export const OK = 0;
export const LONG_STEP = 1;
export const UNSOLVED = 2;
export const NOT_FINITE = 4;
export const OUT_OF_ENVELOPE = 7;

const [DONE, RECORD] = [0, 3];
const FIRST_RECORD = 1024;
/** Rows of which the outputs are computed at once. */
const OBSERVED = 4096;
const MARCH = 120;
const DRIVE = 56;
const ROUNDS = 4096;
/** Steps after which a run is given up. */
export const MOST_STEPS = 2_000_000;

interface Exports {
  memory: WebAssembly.Memory;
  __heap_base: WebAssembly.Global;
  list_losses(p: number, y: number): number;
  march_on?(march: number, block: number, begin: number): number;
  size_of_block?(): number;
  observe_rows?(runs: number, counts: number, p: number, x: number, y: number): void;
  march?(...numbers: number[]): void;
}

export class TooLong extends Error {}

/** A loaded module. */
export class RunModule {
  private readonly calls: Exports;
  private top = 0;

  constructor(
    module: WebAssembly.Module,
    readonly layout: Layout,
  ) {
    this.calls = new WebAssembly.Instance(module).exports as unknown as Exports;
  }

  private clear(): void {
    this.top = (Number(this.calls.__heap_base.value) + 15) & ~15;
  }

  /** Room for so many bytes. */
  private take(bytes: number): number {
    const at = this.top;
    this.top = (at + bytes + 15) & ~15;
    const missing = this.top - this.calls.memory.buffer.byteLength;
    if (missing > 0) this.grow(missing);
    return at;
  }

  private grow(bytes: number): void {
    try {
      this.calls.memory.grow(Math.ceil(bytes / 65536));
    } catch {
      throw new TooLong();
    }
  }

  private put(values: Float64Array | Int32Array): number {
    const at = this.take(Math.max(8, values.byteLength));
    if (values instanceof Float64Array) new Float64Array(this.calls.memory.buffer, at, values.length).set(values);
    else new Int32Array(this.calls.memory.buffer, at, values.length).set(values);
    return at;
  }

  private fill(count: number, value: number): number {
    const at = this.take(8 * Math.max(1, count));
    new Float64Array(this.calls.memory.buffer, at, Math.max(1, count)).fill(value);
    return at;
  }

  private get(at: number, count: number): Float64Array {
    return new Float64Array(this.calls.memory.buffer, at, count).slice();
  }

  /** A tenth of the least thermal time constant [s]; see `simulate.api.longest_step`. */
  findLongestStep(parameters: Float64Array): number {
    this.clear();
    const p = this.put(parameters);
    const y = this.fill(512, 0);
    const found = this.get(y, this.calls.list_losses(p, y));
    let least = Infinity;
    for (let k = 0; k < found.length; k += 2) {
      const lost = found[k + 1]!;
      if (lost > 0) least = Math.min(least, (0.1 * found[k]!) / lost);
    }
    return least;
  }

  /** One run, to its end or to where it cannot go on. */
  march(plan: Plan): Marched {
    const { layout, calls } = this;
    const { judged, outputs, said } = layout;
    const samples = plan.times.length;
    this.clear();
    const at = this.take(MARCH);
    const drives = this.putDrives(plan.drives);
    const times = new Float64Array(samples + 1);
    times.set(plan.times);
    times[samples] = Infinity;
    const limits = new Float64Array(2 * layout.envelope);
    limits.set(plan.low);
    limits.set(plan.high, layout.envelope);
    const p = this.put(plan.parameters);
    const first = this.fill(1, plan.first);
    const when = this.put(times);
    const bounds = this.put(limits);
    const ranges = this.put(plan.ranges ?? new Float64Array(judged));
    const rows = this.fill(samples * outputs, NaN);
    const numbers = this.fill(said + judged, 0);
    const states = plan.state ? this.put(plan.state) : this.fill(layout.size, 0);
    const extremes = this.put(new Float64Array(2 * judged).fill(-Infinity, judged).fill(Infinity, 0, judged));
    const block = this.take(calls.size_of_block!());
    const width = recordWidth(layout.drives, layout.recorded);
    let capacity = plan.recorded ? FIRST_RECORD : 0;
    const record = this.take(8 * width * capacity); // the last, so that it can become longer
    const view = new DataView(calls.memory.buffer);
    // runs, samples, rounds, recording, parted, recorded, capacity
    [1, samples, ROUNDS, Number(capacity > 0), Number(plan.parted), 0, capacity].forEach((x, k) => view.setInt32(at + 4 * k, x, true));
    [plan.tolerance, plan.times[samples - 1]!, plan.step, plan.shortest].forEach((x, k) => view.setFloat64(at + 32 + 8 * k, x, true));
    [p, first, when, drives, bounds, ranges, rows, numbers, record, states, extremes, Number(!!plan.state), 0].forEach((x, k) =>
      view.setInt32(at + 64 + 4 * k, x, true),
    );
    let answer = calls.march_on!(at, block, 1);
    for (let round = 1; answer !== DONE; round++) {
      if (round * ROUNDS > MOST_STEPS) throw new TooLong();
      if (answer === RECORD) {
        this.take(8 * width * capacity);
        capacity *= 2;
        new DataView(calls.memory.buffer).setInt32(at + 24, capacity, true);
      }
      answer = calls.march_on!(at, block, 0);
    }
    const recorded = new DataView(calls.memory.buffer).getInt32(at + 20, true);
    return {
      ...this.read(plan, this.get(rows, samples * outputs), this.get(numbers, said + judged)),
      state: this.get(states, layout.size),
      record: this.get(record, width * recorded),
    };
  }

  /** Outputs of states under signals, row by row. */
  observe(parameters: Float64Array, { times, inputs }: TrackRows): Float64Array {
    const { outputs, recorded, drives } = this.layout;
    const [width, found] = [recorded + drives, new Float64Array(outputs * times.length)];
    for (let from = 0; from < times.length; from += OBSERVED) {
      const count = Math.min(OBSERVED, times.length - from);
      this.clear();
      const p = this.put(parameters);
      const x = this.put(Float64Array.from(inputs.slice(width * from, width * (from + count))));
      const y = this.fill(outputs * count, NaN);
      this.calls.observe_rows!(1, this.put(Int32Array.of(count)), p, x, y);
      found.set(this.get(y, outputs * count), outputs * from);
    }
    return found;
  }

  private putDrives(drives: DriveTable[]): number {
    const at = this.take(DRIVE * Math.max(1, drives.length));
    drives.forEach(({ segments, tones, table }, k) => {
      const columns = this.put(table);
      const own = at + DRIVE * k;
      const view = new DataView(this.calls.memory.buffer);
      view.setInt32(own, segments, true);
      view.setInt32(own + 4, tones, true);
      for (let c = 0; c < 4; c++) view.setInt32(own + 8 + 4 * c, columns + 8 * segments * c, true);
      for (let c = 0; c < 3; c++) view.setInt32(own + 24 + 4 * c, columns + 8 * (4 * segments + tones * c), true);
      let fastest = 0;
      for (let j = 0; j < tones; j++) fastest = Math.max(fastest, table[4 * segments + tones + j]!);
      view.setFloat64(own + 40, fastest, true);
      view.setInt32(own + 48, 1, true); // nothing comes after what is known
    });
    return at;
  }

  private read(plan: Plan, rows: Float64Array, numbers: Float64Array): Omit<Marched, "state" | "record"> {
    const { outputs, said } = this.layout;
    const [status = 0, time = 0, place = -1, value = 0, steps = 0, rejected = 0, longest = 0] = numbers;
    const failed = status >= UNSOLVED;
    let reached = plan.times.length;
    if (failed) {
      reached = 0;
      while (reached < plan.times.length && plan.times[reached]! <= time) reached++;
    }
    const kept = rows.subarray(0, reached * outputs);
    const finite = failed || kept.every(Number.isFinite);
    return {
      rows: kept,
      reached,
      ranges: numbers.slice(said),
      status: finite ? status : NOT_FINITE,
      time,
      place,
      value,
      steps,
      rejected,
      longest,
      ripple: numbers[7] ?? 0,
      residual: numbers[8] ?? 0,
      putIn: numbers[9] ?? 0,
      lost: numbers[10] ?? 0,
      accounts: numbers.slice(11, this.layout.decided),
      decision: [...numbers.slice(this.layout.decided, said)],
    };
  }

  /** One run of a system in discrete time, from rest or from a state. */
  marchGiven(parameters: Float64Array, grid: Grid, low: Float64Array, high: Float64Array, state: Float64Array | null = null): Given {
    const { layout, calls } = this;
    const samples = grid.counts.length + 1;
    this.clear();
    const p = this.put(parameters);
    const first = this.put(grid.first);
    const sampled = this.put(grid.sampled);
    const counts = this.put(grid.counts);
    const drives = this.put(grid.drives);
    const lengths = this.put(grid.lengths);
    const rows = this.fill(samples * layout.outputs, 0);
    const worst = this.fill(layout.reports, 0);
    const bounds = new Float64Array(low.length + high.length);
    bounds.set(low);
    bounds.set(high, low.length);
    const limits = this.put(bounds);
    const left = this.fill(1, Infinity);
    const states = state ? this.put(state) : this.fill(Math.max(1, layout.size), NaN);
    calls.march!(1, grid.counts.length, p, first, sampled, counts, drives, lengths, rows, worst, limits, left, states);
    return {
      rows: this.get(rows, samples * layout.outputs),
      worst: this.get(worst, layout.reports),
      left: this.get(left, 1)[0]!,
      state: this.get(states, layout.size),
    };
  }
}
