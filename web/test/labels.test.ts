// Source of truth: the labels of the bench for the same parameters.

import assert from "node:assert/strict";
import { test } from "node:test";
import { groupPackaged } from "../src/form/packaged.ts";
import { labelsOf } from "../src/sweep/labels.ts";
import type { Target } from "../src/sweep/types.ts";

const target = (name: string, unit = "mm"): Target => ({ name, unit }) as Target;

test("parameters have the labels of the bench; two of one name tell their part", () => {
  const names = ["element.diameter", "environment.temperature", "drive.high", "element.law.A_s", "left.length", "right.length", "environment.cooling.h"];
  const labels = labelsOf(names.map((name) => target(name, name === "drive.high" ? "A" : "mm")));
  assert.deepEqual([...labels.values()], ["Diameter", "Ambient temperature", "Heating current", "A_s", "Length (left)", "Length (right)", "h"]);
});

test("packaged scenarios stand in groups, one wire first, and every one in one group", () => {
  const texts = {
    wire: '[mechanism]\nkind = "dead-weight"', hand: '[mechanism]\nkind = "hand"\n[actuators.a]', beam: '[mechanism]\nkind = "beam-motor"\n[signals]',
    loop: '[mechanism]\nkind = "beam-motor"\n[[controllers]]', single: '[controller]\nkind = "pid"',
  };
  const found = groupPackaged(Object.entries(texts).map(([name, text]) => ({ name, title: name, text })));
  assert.deepEqual(found.map(([title, all]) => [title, all.map(({ name }) => name)]), [
    ["One wire", ["wire"]], ["Fingers, hands, several wires", ["hand"]], ["Beams, motors and tests", ["beam"]], ["Controllers", ["loop", "single"]],
  ]);
});
