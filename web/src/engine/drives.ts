// Signals of drives: segments and tones among the inputs, or readings that were made beforehand.

import type { DriveTable } from "./march.ts";
import type { DriveAt, Scenario } from "./types.ts";

/** Share of a level that is rounding. */
const HAIR = 1e-12;

/** As `blend_levels` in martensite/signals/edges.py, to the last digit. */
const blendLevels = (first: number, last: number, share: number): number =>
  Math.min(Math.max(first + share * (last - first), Math.min(first, last)), Math.max(first, last));

/** What C is told of a drive. */
export function tableOf(drive: DriveAt, inputs: Float64Array): DriveTable {
  const { segments, tones, at } = drive;
  return { segments, tones, table: inputs.slice(at, at + 4 * segments + 3 * tones) };
}

/** A signal at ascending times; see `martensite/signals/reader.py`. */
export function readSignal(scenario: Scenario, drive: DriveAt, inputs: Float64Array, times: Float64Array): Float64Array {
  if (!drive.segments) return decode(scenario, drive.readings);
  const { segments, tones, table } = tableOf(drive, inputs);
  const [start, level, slope, bend] = [0, 1, 2, 3].map((c) => table.subarray(c * segments, (c + 1) * segments));
  const [amplitude, rate, phase] = [0, 1, 2].map((c) => table.subarray(4 * segments + c * tones, 4 * segments + (c + 1) * tones));
  let place = 0;
  return times.map((time) => {
    while (place + 1 < segments && start![place + 1]! <= time) place++;
    const along = time - start![place]!;
    const next = place + 1 < segments && slope![place] && !bend![place] ? level![place + 1]! : NaN;
    let sum = level![place]! + (slope![place]! + bend![place]! * along) * along;
    const hair = HAIR * Math.max(Math.abs(level![place]!), Math.abs(next));
    if (Math.abs(sum + slope![place]! * (start![place + 1]! - time) - next) <= hair) {
      sum = blendLevels(level![place]!, next, along / (start![place + 1]! - start![place]!));
    }
    for (let j = 0; j < tones; j++) sum += amplitude![j]! * Math.cos(rate![j]! * time + phase![j]!);
    return sum;
  });
}

const decoded = new WeakMap<Scenario, Map<number, Float64Array>>();

/** Readings from base 64, once. */
function decode(scenario: Scenario, number: number): Float64Array {
  const known = decoded.get(scenario) ?? new Map<number, Float64Array>();
  decoded.set(scenario, known);
  const found = known.get(number) ?? new Float64Array(Uint8Array.from(atob(scenario.readings[number]!), (c) => c.charCodeAt(0)).buffer);
  known.set(number, found);
  return found;
}
