// Long straight parts are drawn broken; what bends, what turns, and the order of points stay.

import assert from "node:assert/strict";
import { test } from "node:test";
import type { SceneData, Shape } from "../src/lib/types.ts";
import { drawnAt, findCuts, lengthOf } from "../src/scene/cuts.ts";
import { chooseBar } from "../src/scene/camera.ts";

const line = (kind: Shape["kind"], points: number[], more: Partial<Shape> = {}): Shape => ({
  name: kind, kind, size: 1e-3, count: points.length / 3, still: points, ...more,
});
const scene = (...shapes: Shape[]): SceneData => ({
  shapes, times: [0], quantum: 1e-3, newton: 5e-3, frames: [[]], turns: [[]], low: [0, 0, 0], high: [450, 4, 16].map((x) => x / 1000) as [number, number, number], ports: {},
});
const wall = line("wall", [0, 0, -8, 0, 0, 8]);
const wheel = line("pulley", [450, -2, 0, 450, 2, 0], { size: 4e-3 });

test("a wire of 450 mm before a wheel of 8 mm loses most of its length, along its own axis only", () => {
  const cuts = findCuts([scene(wall, line("wire", [0, 0, 4, 450, 0, 4], { port: "a" }), wheel)]);
  assert.deepEqual(cuts.map((cut) => cut.axis), [0]);
  const lost = cuts.reduce((sum, cut) => sum + lengthOf(cut), 0);
  assert.ok(lost > 0.35 && lost < 0.44);
  const drawn = Array.from({ length: 46 }, (_, k) => drawnAt(cuts, 0, 0.01 * k));
  drawn.forEach((x, k) => assert.ok(k === 0 || x > (drawn[k - 1] as number)));
  assert.ok(Math.abs((drawn.at(-1) as number) - (drawn[0] as number) - (0.45 - lost)) < 1e-12);
});

test("a wire at an angle and a coil are never broken", () => {
  assert.deepEqual(findCuts([scene(wall, line("wire", [0, 0, 4, 450, 0, 40], { port: "a" }), wheel)]), []);
  assert.deepEqual(findCuts([scene(wall, line("wire", [0, 0, 4, 450, 0, 4], { port: "a", coil: 6e-3 }), wheel)]), []);
});

test("a scale bar has a round length and fits into a corner", () => {
  assert.deepEqual(chooseBar(1000), [0.1, 100]);
  for (const scale of [37, 480, 999, 12345]) {
    const [length, pixels] = chooseBar(scale);
    assert.ok(pixels >= 48 && pixels <= 120 && Math.abs(length * scale - pixels) < 1e-9);
  }
});
