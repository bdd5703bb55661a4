// Signals of benches: a ramp is read as Python's `Ramp` reads it, in every bit.

import assert from "node:assert/strict";
import { test } from "node:test";
import { readSignal } from "../src/engine/drives.ts";
import type { DriveAt, Scenario } from "../src/engine/types.ts";

const read = (rows: number[][], times: Float64Array): Float64Array => {
  const table = Float64Array.from([0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column]!)));
  const drive = { segments: rows.length, tones: 0, at: 0, readings: 0 } as DriveAt;
  return readSignal({} as Scenario, drive, table, times);
};
const times = Float64Array.from({ length: 500 }, (_, k) => 0.1379 * k);

test("a ramp has the bits of its levels and its share, not those of its slope", () => {
  const found = read([[0, 0.3, 13.7 / 70, 0], [70, 14, 0, 0]], times);
  const meant = times.map((time) => Math.min(Math.max(0.3 + (time / 70) * (14 - 0.3), 0.3), 14));
  assert.deepEqual(found, meant);
  const sloping = times.map((time) => 0.3 + (13.7 / 70) * time);
  assert.ok(sloping.some((one, k) => one !== meant[k]));
});

test("a slope that ends in a jump, or in nothing known, is followed", () => {
  const short = times.subarray(0, 5);
  assert.deepEqual(read([[0, 1, 2, 0], [70, 14, 0, 0]], short), short.map((time) => 1 + 2 * time));
  assert.deepEqual(read([[0, 1, 2, 0]], short), short.map((time) => 1 + 2 * time));
});
