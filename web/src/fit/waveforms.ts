// A drive that follows a column: martensite/scenario/recorded_waveforms.py, and its segments for C.

import type { DriveTable } from "../engine/march.ts";

/** Units of drives that are switched: a column of them that rests and jumps is held. */
const STEPPED = ["V", "A", "W", "1"];
const [JUMP, RESTING, MOSTLY] = [0.1, 0.02, 0.9];
const JUST_BEFORE = 1e-4;
type Row = readonly [time: number, level: number];

/** Rows that a signal goes through, from 0 s on; rows without a number are bridged. */
export function followColumn(times: Float64Array, values: Float64Array, si: string): { rows: Row[]; held: boolean } {
  const known = [...times.keys()].filter((k) => Number.isFinite(values[k]!)).map((k): Row => [times[k]! - times[0]!, values[k]!]);
  const held = STEPPED.includes(si) && isStepped(known.map(([, x]) => x));
  return { rows: held ? holdLevels(known) : known, held };
}

/** Whether a column rests at levels and jumps between them. */
function isStepped(values: number[]): boolean {
  const reach = values.reduce((most, x) => Math.max(most, x), -Infinity) - values.reduce((least, x) => Math.min(least, x), Infinity);
  const changes = values.slice(1).map((x, k) => Math.abs(x - values[k]!));
  const jumps = [...changes.keys()].filter((k) => changes[k]! > JUMP * reach);
  const quiet = jumps.filter((k) => Math.max(changes[k - 1] ?? 0, changes[k + 1] ?? 0) <= RESTING * reach);
  return jumps.length > 0 && quiet.length >= MOSTLY * jumps.length;
}

/** Every level held until just before the next row. */
function holdLevels(rows: Row[]): Row[] {
  return rows.flatMap(([time, level], k): Row[] => {
    const before = rows[k - 1];
    if (!before || before[1] === level) return [[time, level]];
    return [[time - JUST_BEFORE * (time - before[0]), before[1]], [time, level]];
  });
}

/** Straight lines between rows, the level of the first before and that of the last behind them. */
export function makeSegments(rows: Row[]): DriveTable {
  const found: [number, number, number][] = rows[0]![0] > 0 ? [[0, rows[0]![1], 0]] : [];
  rows.forEach(([time, level], k) => {
    const next = rows[k + 1];
    found.push([time, level, next ? (next[1] - level) / (next[0] - time) : 0]);
  });
  const count = found.length;
  const table = new Float64Array(4 * count);
  found.forEach(([start, level, slope], k) => {
    table[k] = start;
    table[count + k] = level;
    table[2 * count + k] = slope;
  });
  return { segments: count, tones: 0, table };
}
