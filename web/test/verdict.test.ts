import assert from "node:assert/strict";
import { test } from "node:test";
import type { Tally } from "../src/studies/types.ts";
import { describeTally, rankVerdict } from "../src/studies/verdict.tsx";

const NONE: Tally = { reproduced: 0, disagrees: 0, misprint: 0, "self-contradictory": 0, "not comparable": 0, recovery: 0 };

test("a tally says what could fail, and what could not", () => {
  const said = describeTally({ ...NONE, reproduced: 3, disagrees: 1, misprint: 1, "not comparable": 2 });
  assert.equal(said, "Of 4 printed values that can be compared, 3 are reproduced. 1 contradicts the source itself. 2 cannot be compared; the table gives the reasons.");
  assert.equal(describeTally(NONE), "No printed value can be compared.");
});

test("what was compared comes first", () => {
  assert.ok(rankVerdict("disagrees") < rankVerdict("misprint") && rankVerdict("misprint") < rankVerdict("not comparable"));
});
