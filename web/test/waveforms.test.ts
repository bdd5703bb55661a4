import assert from "node:assert/strict";
import { test } from "node:test";
import { followColumn, makeSegments } from "../src/fit/waveforms.ts";

test("a command that is switched is held from row to row, and a ramp is a straight line", () => {
  const times = Float64Array.of(10, 11, 12, 13);
  const switched = followColumn(times, Float64Array.of(0, 0, 5, 5), "V");
  assert.equal(switched.held, true);
  assert.deepEqual(switched.rows.map(([, level]) => level), [0, 0, 0, 5, 5]);
  assert.ok(Math.abs(switched.rows[2]![0] - 1.9999) < 1e-12);
  const ramp = followColumn(times, Float64Array.of(0, 1, NaN, 3), "V");
  assert.deepEqual([ramp.held, ramp.rows], [false, [[0, 0], [1, 1], [3, 3]]]);
  assert.equal(followColumn(times, Float64Array.of(20, 20, 90, 90), "K").held, false);
});

test("segments are starts, levels and slopes, column by column; the last one stays", () => {
  const { segments, tones, table } = makeSegments([[1, 2], [3, 6]]);
  assert.deepEqual([segments, tones, [...table]], [3, 0, [0, 1, 3, 2, 2, 6, 0, 2, 0, 0, 0, 0]]);
});
