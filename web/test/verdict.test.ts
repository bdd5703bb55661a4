import assert from "node:assert/strict";
import { test } from "node:test";
import { listPairs, placeOn } from "../src/studies/pairs.ts";
import type { Claim, Tally, Verdict } from "../src/studies/types.ts";
import { describeTally, rankVerdict } from "../src/studies/verdict.tsx";

const NONE: Tally = { reproduced: 0, disagrees: 0, misprint: 0, "self-contradictory": 0, "not comparable": 0, recovery: 0 };

test("a tally states what was compared, and does not read as a failure", () => {
  const said = describeTally({ ...NONE, reproduced: 3, disagrees: 1, misprint: 1, "not comparable": 2 });
  assert.equal(said, "3 of 4 comparable printed values are reproduced. 1 error in print is explained. 2 values were fitted or come from another wire, and get no verdict.");
  const open = describeTally({ ...NONE, misprint: 2, "self-contradictory": 3, recovery: 4 });
  assert.equal(open, "5 errors in print are explained. 4 values were fitted or come from another wire, and get no verdict.");
  for (const text of [open, describeTally({ ...NONE, "not comparable": 5 })]) assert.doesNotMatch(text, /\bNo\b|cannot|\b0\b/);
});

test("what was compared comes first", () => {
  assert.ok(rankVerdict("disagrees") < rankVerdict("misprint") && rankVerdict("misprint") < rankVerdict("not comparable"));
});

test("values are drawn by their factor, and errors in print come first", () => {
  assert.equal(placeOn(3, 3), 0);
  assert.equal(placeOn(20, 2), 1);
  assert.equal(placeOn(0.2, 2), -1);
  assert.ok(placeOn(2.2, 2) > 0.15 && placeOn(2.2, 2) < 0.25); // a tenth is seen
  assert.deepEqual([placeOn(0, 2), placeOn(-5, 2), placeOn(17, -1200)], [-1, -1, 1]); // another sign is beyond all factors
  const claim = (verdict: Verdict, published: number | null, as_printed: number | null = null): Claim => ({ id: verdict, verdict, published, as_printed, computed: 1 }) as Claim;
  const pairs = listPairs([claim("reproduced", 1), claim("recovery", 2), claim("not comparable", null), claim("misprint", null, 3)]);
  assert.deepEqual(pairs.map((pair) => [pair.claim.id, pair.printed]), [["misprint", 3], ["reproduced", 1], ["recovery", 2]]);
});
