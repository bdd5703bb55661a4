import assert from "node:assert/strict";
import { test } from "node:test";
import { writeCard } from "../src/share/card.ts";
import type { Run } from "../src/lib/types.ts";
import { chooseTarget, scoreHold } from "../src/touch/score.ts";

const made = (positions: number[], how: { display_unit: string; factor: number; offset: number }): Run => {
  const [low, high] = [Math.min(...positions), Math.max(...positions)];
  return { coordinate: "x", columns: { x: positions }, ends: { x: [low, high] }, stroke: high - low, outputs: { x: how } } as unknown as Run;
};
const MM = { display_unit: "mm", factor: 1000, offset: 0 };

test("a quarter of the stroke is to be held, as a round number of the unit that is shown", () => {
  const up = chooseTarget(made([0, 0.0118, 0.001], MM))!;
  assert.equal(up.words, "3 mm");
  assert.ok(Math.abs(up.at - 0.003) < 1e-12 && Math.abs(up.band - 0.00015) < 1e-12);
  assert.equal(chooseTarget(made([0, -0.0118], MM))!.words, "-3 mm"); // it moves the other way
  assert.equal(chooseTarget(made([0, 2.64], { display_unit: "deg", factor: 180 / Math.PI, offset: 0 }))!.words, "40 °");
  assert.equal(chooseTarget(made([0.001, 0.001], MM)), null);
});

test("the score is the share of the time within the band, whatever the samples", () => {
  const target = { at: 0.003, band: 0.00015 };
  const found = scoreHold([0, 1, 4], [0.003, 0.004, 0.003], target);
  assert.ok(found.points === 25 && Math.abs(found.rms - Math.sqrt(0.75) * 1e-3) < 1e-12);
  assert.equal(scoreHold([0, 20], [0.0031, 0], target).points, 100);
  assert.equal(scoreHold([0], [0.003], target).points, 0);
});

test("a run is shared as text with its numbers and its address", () => {
  const card = { title: "A wire", about: "", numbers: [["Stroke", "5.9 mm"]] as [string, string][], note: "I held 3 mm by hand: 43 of 100 points" };
  assert.equal(writeCard(card, "http://here/#/bench"), "A wire\nI held 3 mm by hand: 43 of 100 points\nStroke: 5.9 mm\nhttp://here/#/bench");
});
