import assert from "node:assert/strict";
import { test } from "node:test";
import type { Run } from "../src/lib/types.ts";
import { insightOf, writePromise } from "../src/views/insight.ts";
import { scaledRow } from "../src/views/remedies.ts";
import { endsOf } from "../src/views/columns.ts";
import { isConcerned, cycleOf, measureDeviation, measures } from "../src/views/results.ts";

const how = (unit: string, display_unit = unit, factor = 1, offset = 0) => ({ unit, display_unit, factor, offset, long_name: unit, symbol: unit });
const STEP = 0.01;

/** Heated by 1 W from 1 s on; it goes out from 2 s to 3 s, and comes back so long after the heat ends at 4 s. */
function made(back: number, wait = 1, extra: Partial<Run> = {}): Run {
  const times = Array.from({ length: 1201 }, (_, k) => k * STEP);
  const out = (t: number): number => Math.min(Math.max(t - 2, 0), 1) - Math.min(Math.max((t - 4 - wait) / (back - wait), 0), 1);
  const electrical = times.map((t) => Math.min(Math.max(t - 1, 0), 3));
  const run = {
    times, text: "", ports: ["element"], coordinate: "position", stroke: 0.01, alarms: [],
    columns: {
      position: times.map((t) => 0.01 * out(t)), power: times.map((t) => (t > 1 - 1e-9 && t < 4 - 1e-9 ? 1 : 0)),
      hottest: times.map((t) => 300 + 100 * out(t)), stress: times.map(() => 90e6),
    },
    outputs: { position: how("m", "mm", 1000), hottest: how("K", "degC", 1, -273.15), stress: how("Pa", "MPa", 1e-6) },
    energy: { courses: [{ key: "electrical", values: electrical }], efficiency: times.map(() => 0.02), sentence: "" },
  };
  return { ...run, ends: endsOf(run.columns), ...extra } as unknown as Run;
}

const near = (value: number | null | undefined, wanted: number): void => assert.ok(Math.abs((value ?? NaN) - wanted) < 2 * STEP, `${value} is not ${wanted}`);

test("times go from the ends of heat to 90 % and 10 % of the stroke", () => {
  const cycle = cycleOf(made(4));
  near(cycle?.up, 1.9);
  near(cycle?.wait, 1.3);
  near(cycle?.down, 3.7);
  near(cycle?.off, 4);
  assert.equal(cycle?.count, 1);
});

test("what does not come back within the run has no time down, and no energy of a cycle", () => {
  const run = made(40);
  assert.equal(cycleOf(run)?.down, null);
  assert.match(insightOf(run)?.sentence ?? "", /does not return/);
  assert.equal(measures(run).find((one) => one.key === "energy")?.name, "Energy");
});

test("pulses with short pauses are one heating", () => {
  const run = made(4);
  const pulsed = run.times.map((t, k) => (t > 1 - 1e-9 && t < 4 - 1e-9 && k % 4 < 2 ? 2 : 0));
  near(cycleOf({ ...run, columns: { ...run.columns, power: pulsed } })?.up, 1.9);
});

test("the sentence tells the share that the numbers have, and a promise is the ratio of two runs", () => {
  const [slow, fast] = [made(4), made(2, 0.5)];
  assert.match(insightOf(slow)?.sentence ?? "", /^Cooling takes 66 % of the cycle: 3\.7 s to return \(including 1\.3 s of cooling from 127 °C before it moves\), 1\.9 s to contract\.$/);
  assert.match(writePromise(slow, fast, "cooling", "a fan"), /^With a fan, the actuator would return in about 1\.8 s, 2 times as fast\.$/);
  assert.match(writePromise(slow, fast, "cooling", "two", 2), /for 2 times the energy/);
  assert.equal(writePromise(fast, slow, "cooling", "a jacket"), "");
});

test("a loop is told by its deviation from the reference", () => {
  const run = made(4);
  const columns = { ...run.columns, reference: run.columns["position"]!.map((x) => x + 0.001) };
  const loop = { ...run, columns, outputs: { ...run.outputs, reference: how("m", "mm", 1000) } } as Run;
  near(1e3 * (measureDeviation(loop)?.rms ?? 0), 1);
  assert.equal(measureDeviation(loop)?.cooling, 0);
  assert.match(insightOf(loop)?.sentence ?? "", /error is 1 mm RMS, 10 % of the stroke; 100 % .* must heat/);
});

test("what a law says about a stress concerns a run that comes half as far", () => {
  const run = made(4);
  assert.ok(!isConcerned(run, "the strips overlap above 1792 MPa."));
  assert.ok(isConcerned(run, "the strips overlap above 170 MPa."));
  assert.ok(isConcerned(run, "A_s is below M_s."));
});

test("a list of quantities is drawn as a whole", () => {
  assert.deepEqual(scaledRow("0 W, 2 W, -1.5e-1 W", 0.25), ["0 W", "0.5 W", "-0.0375 W"]);
});
