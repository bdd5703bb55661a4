import assert from "node:assert/strict";
import { test } from "node:test";
import { BOUNDED, CONVERGED, descendSquares } from "../src/fit/descent.ts";
import { estimateUncertainty, findStudent } from "../src/fit/uncertainty.ts";

const TIMES = Array.from({ length: 200 }, (_, k) => k / 20);

/** A scatter that is the same in every run: a generator of Park and Miller, sums of twelve. */
function scatter(seed: number): () => number {
  let state = seed;
  const draw = (): number => (state = (state * 48271) % 2147483647) / 2147483647;
  return () => Array.from({ length: 12 }, draw).reduce((sum, x) => sum + x, -6);
}

/** a exp(-b t) with noise, in a box: a from 0 to 4, b from 0 to 2. */
function decayed(noise: number, seed = 7): Float64Array {
  const next = scatter(seed);
  return Float64Array.from(TIMES, (t) => 2.5 * Math.exp(-0.8 * t) + noise * next());
}

const compare = (measured: Float64Array, model: (t: number, u: readonly number[]) => number) => (u: readonly number[]) => ({
  residuals: measured.map((x, k) => model(TIMES[k]!, u) - x),
  extra: null,
});
const decay = (t: number, [a = 0, b = 0]: readonly number[]): number => 4 * a * Math.exp(-2 * b * t);

test("a decay is found again within its intervals, which hold in nearly all of many draws", () => {
  let inside = 0;
  for (let seed = 1; seed <= 60; seed++) {
    const found = descendSquares(compare(decayed(0.05, seed * 7919), decay), [0.2, 0.9]);
    assert.equal(found.reason, CONVERGED);
    const { widened, effective, rank } = estimateUncertainty(found.residuals, found.jacobian, [TIMES.length]);
    assert.equal(rank, 2);
    assert.ok(effective > 60);
    inside += Number(Math.abs(found.shares[0]! - 0.625) < widened[0]!) + Number(Math.abs(found.shares[1]! - 0.4) < widened[1]!);
  }
  assert.ok(inside >= 107 && inside <= 120, `${inside} of 120`);
});

test("residuals with a scatter of their own are followed to within it", () => {
  const next = scatter(3);
  const noisy = compare(decayed(0), (t, u) => decay(t, u) + 1e-6 * next());
  const found = descendSquares(noisy, [0.9, 0.1]);
  assert.equal(found.reason, CONVERGED);
  assert.ok(found.noise > 3e-7 && found.noise < 3e-6, `${found.noise}`);
  assert.ok(Math.abs(found.shares[0]! - 0.625) < 3e-6 && Math.abs(found.shares[1]! - 0.4) < 3e-6);
});

test("numbers of which only the product counts are not determined, and neither is one without effect", () => {
  const found = descendSquares(compare(decayed(0.01), (t, u) => decay(t, [u[0]! * u[1]!, u[2]!]) + 0 * u[3]!), [0.6, 0.7, 0.3, 0.5]);
  const { errors, widened, weak, rank } = estimateUncertainty(found.residuals, found.jacobian, [TIMES.length]);
  assert.equal(rank, 2);
  assert.deepEqual([0, 1, 3].map((k) => errors[k]), [Infinity, Infinity, Infinity]);
  assert.ok(Math.abs(found.shares[2]! - 0.4) < widened[2]!);
  assert.deepEqual(weak.map((one) => one.places), [[3], [0, 1]]);
  assert.ok(Math.abs(found.shares[0]! * found.shares[1]! - 0.625) < 0.01);
});

test("an optimum beyond a bound is said to be there, and never to have converged", () => {
  const found = descendSquares(compare(decayed(0.01), (t, [a = 0, b = 0]) => decay(t, [a, 0.3 * b])), [0.5, 0.5]);
  assert.equal(found.reason, BOUNDED);
  assert.equal(found.shares[1], 1);
});

test("where runs fail the search turns back, and a start that fails is refused", () => {
  const walled = (u: readonly number[]) => (u[1]! > 0.95 ? null : compare(decayed(0.01), decay)(u));
  assert.equal(descendSquares(walled, [0.05, 0.94]).reason, CONVERGED);
  assert.throws(() => descendSquares(walled, [0.5, 0.99]), /fails at the start/);
});

test("quantiles of Student's t are those of tables", () => {
  for (const [freedom, value] of [[1, 12.7062], [2, 4.3027], [4, 2.7764], [5, 2.5706], [10, 2.2281], [100, 1.984]] as const) {
    assert.ok(Math.abs(findStudent(freedom) - value) < 4e-3, `${freedom}: ${findStudent(freedom)}`);
  }
});
