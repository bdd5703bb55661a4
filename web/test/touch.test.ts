import assert from "node:assert/strict";
import { test } from "node:test";
import { flattenTable, readToml } from "../src/engine/toml.ts";
import type { Scenario } from "../src/engine/types.ts";
import type { Run } from "../src/lib/types.ts";
import { dragLoad, HANDLES, kindOf, type Load } from "../src/touch/handles.ts";
import { Recording } from "../src/touch/recording.ts";

const load = (kind: string): Load => ({ ...HANDLES[kind]!, value: 0.3, low: 0.1, high: 0.9, unit: "kg", how: { display_unit: "g", factor: 1000, offset: 0 } });

test("a body that is dragged along its way changes its number, by its whole range across the picture", () => {
  const weight = load("dead-weight");
  assert.equal(dragLoad(weight, 0.3, [0, 0, -0.1], 0.4), 0.5);
  assert.equal(dragLoad(weight, 0.3, [0.2, 0.2, 0], 0.4), 0.3); // across its way
  assert.equal(dragLoad(weight, 0.3, [0, 0, 5], 0.4), 0.1);
  assert.equal(dragLoad(weight, 0.3, [0, 0, -5], 0.4), 0.9);
});

test("the kind of a mechanism is read where it is a table and where it is a word", () => {
  assert.equal(kindOf('[mechanism]\nkind = "finger"\n'), "finger");
  assert.equal(kindOf('mechanism = "lever"\n'), "lever");
  assert.equal(kindOf(""), "");
});

const drive = { name: "drive", port: "element", how: { unit: "W", display_unit: "W", factor: 1, offset: 0 } };
const scenario = { names: ["drive", "temperature"], places: { drives: [drive] } } as unknown as Scenario;

test("what was held is written as a table with jumps", () => {
  const made = new Recording(scenario, { scene: {} } as Run);
  const add = (times: number[], level: number): void =>
    made.add({ times: Float64Array.from(times), rows: Float64Array.from(times.flatMap((t) => [level, 300 + t])), levels: [level], seconds: 0 });
  add([0, 0.5], 0), add([1], 0), add([1.5, 2], 0.45), add([3], 0);
  assert.equal(made.now("temperature"), 303);
  const text = made.write('[drive]\nkind = "power"\nwaveform = { kind = "step", high = "1 W" }\n[run]\nduration = "9 s"\n', {}, () => "drive.waveform");
  const found = flattenTable(readToml(text!));
  assert.equal(found.get("run.duration"), "3 s");
  assert.match(text!, /waveform = \{ kind = "table", times = \["0 s", "1 s", "1.000001 s", "2 s", "2.000001 s", "3 s"\], values = \["0 W", "0 W", "0.45 W", "0.45 W", "0 W", "0 W"\] \}/);
});

test("a drive that is no part of the document is not written", () => {
  const made = new Recording(scenario, { scene: {} } as Run);
  made.add({ times: Float64Array.of(0, 1), rows: Float64Array.of(1, 300, 1, 300), levels: [1], seconds: 0 });
  assert.equal(made.write("[run]\nduration = \"9 s\"\n", {}, () => ""), null);
  assert.equal(made.write("[run]\nduration = \"9 s\"\n", {}, () => "drive.waveform"), null);
});

test("a long recording keeps every second sample, and its end", () => {
  const made = new Recording(scenario, { scene: {} } as Run);
  for (let k = 0; k <= 6000; k++) made.add({ times: Float64Array.of(k), rows: Float64Array.of(0, k), levels: [0], seconds: 0 });
  assert.equal(made.times.length, 3001);
  assert.equal(made.end, 6000);
});
