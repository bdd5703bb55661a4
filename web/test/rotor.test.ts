import assert from "node:assert/strict";
import { test } from "node:test";
import type { Run } from "../src/lib/types.ts";
import { findJump, findResonance } from "../src/views/rotor.ts";

/** A motor in a ramp of 0.2 V/s, held at the resonance until a time [s], then three times as fast. */
function ramp(until: number): Run {
  const times = Array.from({ length: 2001 }, (_, k) => 0.02 * k);
  const speed = times.map((t) => (t < until ? 50 : 150) + 20 * Math.sin(55 * t)); // it swings in each turn
  return { times, resonance: 50, columns: { rotor_speed: speed, motor: times.map((t) => 0.2 * t) } } as unknown as Run;
}

test("a motor jumps at the last voltage at which the resonance holds it", () => {
  assert.ok(Math.abs(findJump(ramp(30))! - 6) < 0.2 * 0.25);
  assert.equal(findJump(ramp(100)), null); // held to the end
  assert.equal(findJump(ramp(-1)), null); // never held
});

test("the resonance follows the mass and the stiffness of the run", () => {
  const motor = { rows: [["p", "k"], ["p", "m"], ["div", 0, 1], ["sqrt", 2]] as never, choices: [], resonance: 3 };
  assert.equal(findResonance({ k: 400, m: 0.25 }, { motor }), 40);
  assert.equal(findResonance({}, { motor: { rows: [], choices: [], resonance: null } }), null);
});
