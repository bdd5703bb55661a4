// Outputs of a run at its accepted steps: martensite/simulate/track.py, for one run. Rows stand at both ends of
// every piece of a step, on both sides of jumps, at the levels of drives that switch within a piece, and at
// nodes and extremes of tones. Peaks between rows, which Python looks for on polynomials, are left out here.

import { LOBATTO_END, LOOKED_AT, RESOLVED_ANGLE } from "./constants.ts";
import type { DriveTable } from "./march.ts";

const HEAD = 4;
const [AFTER, BEFORE, MEAN, SQUARE, LOW, HIGH, LAPSE] = [0, 1, 2, 3, 4, 5, 6];
const PER_DRIVE = 7;
const [WHOLE, FIRST, SECOND] = [0, 1, 2];
/** Weights of both ends of a piece in an integral, by its part. */
const WEIGHTS = [[1 / 2, 1 / 2], [1 / 3, 2 / 3], [2 / 3, 1 / 3]] as const;
const JUMP = 1e-9;
const LOBATTO = [0.08488805186071652, 0.2655756032646429, 0.5, 0.7344243967353571, 0.9151119481392835];
const LOBATTO_WEIGHTS = [0.138413023680783, 0.2158726906049313, 0.2438095238095238, 0.2158726906049313, 0.138413023680783];

export const recordWidth = (drives: number, size: number): number => HEAD + PER_DRIVE * drives + size;

/** Recorded states and signals at rows of a track, row by row. */
export interface TrackRows {
  times: number[];
  /** Weight of every row in an integral over time [s]. */
  weights: number[];
  /** The state, then the signals. */
  inputs: number[];
}

/** Rows of a record with so many numbers of the state; long steps, those of order five, also have rows between their nodes. */
export function listTrackRows(record: Float64Array, size: number, drives: DriveTable[], long = false): TrackRows {
  const pieces = new Pieces(record, size, drives);
  const found: TrackRows = { times: [], weights: [], inputs: [] };
  for (let k = 0; k < pieces.count; k++) addPiece(pieces, k, long, found);
  return found;
}

function addPiece(pieces: Pieces, k: number, long: boolean, found: TrackRows): void {
  const add = (share: number, weight: number, signals: number[]): void => {
    found.times.push(pieces.timeAt(k, share));
    found.weights.push(weight);
    found.inputs.push(...pieces.stateAt(k, share), ...signals);
  };
  if (pieces.begins(k)) return add(1, 0, pieces.signalsAt(k, 0));
  const length = pieces.length(k);
  const angles = pieces.drives.map((one) => length * fastest(one));
  const toned = angles.some((angle) => angle > 0) && angles.every((angle) => angle <= RESOLVED_ANGLE);
  const varied = !toned && pieces.drives.some((_, d) => pieces.of(k, d, LAPSE) > 0);
  const [start, end] = toned ? [LOBATTO_END, LOBATTO_END] : varied ? [0, 0] : WEIGHTS[pieces.part(k)]!;
  if (pieces.jumpsAt(k)) add(0, start * length, pieces.signalsAt(k, 0));
  else found.weights[found.weights.length - 1]! += start * length;
  if (toned) for (const [share, weight] of listToneNodes(pieces, k)) add(share, weight * length, pieces.signalsAt(k, share));
  if (varied) addLevels(pieces, k, add);
  if (long && !toned && !varied && pieces.part(k) !== WHOLE) add(0.5, 0, pieces.signalsAt(k, 0.5));
  add(1, end * length, pieces.signalsAt(k, 1));
}

const fastest = ({ segments, tones, table }: DriveTable): number => {
  let found = 0;
  for (let j = 0; j < tones; j++) if (table[4 * segments + j]) found = Math.max(found, table[4 * segments + tones + j]!);
  return found;
};

/** The pieces of a record. */
class Pieces {
  private readonly width: number;

  constructor(
    private readonly record: Float64Array,
    private readonly size: number,
    readonly drives: DriveTable[],
  ) {
    this.width = recordWidth(drives.length, size);
  }

  get count(): number {
    return this.record.length / this.width;
  }

  private at = (k: number, place: number): number => this.record[k * this.width + place]!;
  part = (k: number): number => this.at(k, 1);
  begins = (k: number): boolean => this.part(k) < 0;
  length = (k: number): number => this.at(k, 3);
  timeAt = (k: number, share: number): number => this.at(k, 2) + share * this.length(k);
  of = (k: number, drive: number, what: number): number => this.at(k, HEAD + PER_DRIVE * drive + what);

  signalAt(k: number, drive: number, share: number): number {
    const { segments, tones, table } = this.drives[drive]!;
    const [time, from] = [this.timeAt(k, share), 4 * segments];
    let sum = this.of(k, drive, AFTER) + share * (this.of(k, drive, BEFORE) - this.of(k, drive, AFTER));
    for (let j = 0; j < tones; j++) sum += table[from + j]! * Math.cos(table[from + tones + j]! * time + table[from + 2 * tones + j]!);
    return sum;
  }

  signalsAt = (k: number, share: number): number[] => this.drives.map((_, drive) => this.signalAt(k, drive, share));

  /** Whether a drive jumps at the start of a piece. */
  jumpsAt(k: number): boolean {
    return this.drives.some((_, drive) => {
      const [before, after] = [this.of(k - 1, drive, BEFORE), this.of(k, drive, AFTER)];
      return Math.abs(after - before) > JUMP * Math.max(Math.abs(before), Math.abs(after));
    });
  }

  private endState(k: number): number[] {
    const from = k * this.width + HEAD + PER_DRIVE * this.drives.length;
    return [...this.record.subarray(from, from + this.size)];
  }

  /** The state within a piece: on the parabola through the nodes of a step with halves, else on a straight line. */
  stateAt(k: number, share: number): number[] {
    if (share === 1 || this.begins(k)) return this.endState(k);
    const [part, before] = [this.part(k), this.endState(k - 1)];
    if (share === 0) return before;
    if (part !== FIRST && part !== SECOND) return this.endState(k).map((end, i) => before[i]! + share * (end - before[i]!));
    const [first, middle] = part === SECOND ? [k - 2, k - 1] : [k - 1, k];
    const [a, b, c] = [first, middle, middle + 1].map((one) => this.endState(one)) as [number[], number[], number[]];
    const x = part === SECOND ? share : share - 1;
    return a.map((_, i) => {
      const [p, q, r] = [a[i]!, b[i]!, c[i]!];
      const value = q + 0.5 * x * (r - p) + 0.5 * x * x * (r - 2 * q + p);
      return Math.min(Math.max(value, Math.min(p, q, r)), Math.max(p, q, r));
    });
  }
}

/** Rows at the levels of drives that switch within a piece; the order of the levels is not that of the drive. */
function addLevels(pieces: Pieces, k: number, add: (share: number, weight: number, signals: number[]) => void): void {
  const levels = pieces.drives.map((_, drive) => (pieces.of(k, drive, LAPSE) > 0 ? spreadLevels(pieces, k, drive) : null));
  const cuts = levels.flatMap((own, drive) => (own ? own.ends.map((share) => ({ share, drive })) : [])).sort((a, b) => a.share - b.share);
  const passed = levels.map(() => 0);
  let from = 0;
  for (const { share, drive } of [...cuts, { share: 1, drive: -1 }]) {
    const weight = 0.5 * (share - from) * pieces.length(k);
    for (const place of [from, share]) add(place, weight, levels.map((own, d) => (own ? own.values[passed[d]!]! : pieces.signalAt(k, d, place))));
    from = share;
    if (drive >= 0) passed[drive]!++;
  }
}

/** Four levels with the mean, the mean square and the extremes of a drive, and where the first three end. */
function spreadLevels(pieces: Pieces, k: number, drive: number): { values: number[]; ends: number[] } {
  const [mean, square, low, high] = [MEAN, SQUARE, LOW, HIGH].map((what) => pieces.of(k, drive, what!)) as [number, number, number, number];
  const clip = (x: number, least: number, most: number): number => Math.min(Math.max(x, least), most);
  const centre = 0.5 * (low + high);
  const reach = high > low ? 0.5 * (high - low) : 1;
  const first = clip((mean - centre) / reach, -1, 1);
  const second = clip((square - 2 * centre * mean + centre * centre) / (reach * reach), first * first, 1);
  const outer = second >= Math.abs(first);
  const spread = Math.sqrt(Math.max(square - mean * mean, 0));
  const [a, b] = outer ? [centre, centre] : [clip(mean - spread, low, high), clip(mean + spread, low, high)];
  const [lowest, highest] = outer ? [0.5 * (second - first), 0.5 * (second + first)] : [0, 0];
  const rest = 0.5 * (1 - lowest - highest);
  return { values: [low, a, b, high], ends: [lowest, lowest + rest, lowest + 2 * rest] };
}

/** Places in a piece whose tones are followed, with their weights: nodes of an integral, and extremes of drives. */
function listToneNodes(pieces: Pieces, k: number): [share: number, weight: number][] {
  const found = LOBATTO.map((share, j): [number, number] => [share, LOBATTO_WEIGHTS[j]!]);
  const step = 1 / (LOOKED_AT - 1);
  pieces.drives.forEach((_, drive) => {
    const values = Array.from({ length: LOOKED_AT }, (_, j) => pieces.signalAt(k, drive, j * step));
    for (const sign of [1, -1]) {
      const top = values.reduce((most, value, j) => (sign * value > sign * values[most]! ? j : most), 0);
      if (top === 0 || top === LOOKED_AT - 1) continue;
      const [a, b, c] = [top - 1, top, top + 1].map((j) => sign * values[j]!) as [number, number, number];
      found.push([(top - (0.5 * (c - a)) / Math.min(c - 2 * b + a, -1e-300)) * step, 0]);
    }
  });
  return found.sort(([a], [b]) => a - b);
}

/** Weights of rows in an integral by trapezoids [s]. */
export function weighTrapezoids(times: Float64Array): Float64Array {
  return times.map((time, k) => 0.5 * ((times[k + 1] ?? time) - (times[k - 1] ?? time)));
}
