// Source of truth: the closed forms of a hanging weight, stress = m g / A, and of a heat balance, rise = power / (h d).

import assert from "node:assert/strict";
import { test } from "node:test";
import type { GroupNode } from "../src/form/types.ts";
import type { Alarm, Run } from "../src/lib/types.ts";
import { dangersOf, findCure, knobsOf } from "../src/views/cures.ts";
import { gainOf } from "../src/views/insight.ts";
import { entriesOf, type Changes } from "../src/views/remedies.ts";

const number = (path: string, title: string, value: number, display_unit: string, factor: number) => ({ sort: "number", path, title, value, display_unit, label: display_unit, unit: display_unit, factor, offset: 0 });
const FORM = [
  {
    sort: "group", kind: null,
    items: [
      number("mechanism.mass", "Mass", 0.5, "g", 1000),
      number("element.diameter", "Diameter", 0.15e-3, "mm", 1000),
      number("drive.waveform.high", "High", 2, "W", 1),
    ],
  },
] as unknown as GroupNode[];
const [STRESS, HOT, AROUND] = [172e6, 400, 300];

const alarm = (kind: string, worst: number, limit: number): Alarm => ({ kind, worst, limit, port: "" }) as Alarm;
const read = (changes: Changes, path: string, usual: number): number => (path in changes ? Number.parseFloat(String(changes[path])) : usual);

/** The run of a weight on a wire that moves only when it is hot. */
function lift(changes: Changes): Run {
  const [mass, diameter, power] = [read(changes, "mechanism.mass", 500), read(changes, "element.diameter", 0.15), read(changes, "drive.waveform.high", 2)];
  const stress = (1e-3 * mass * 9.81) / (Math.PI * (0.5e-3 * diameter) ** 2);
  const hottest = AROUND + (45 * power * 0.15) / diameter;
  const alarms = [...(stress > STRESS ? [alarm("stress", stress, STRESS)] : []), ...(hottest > HOT ? [alarm("temperature", hottest, HOT)] : [])];
  return {
    alarms, ports: ["element"], stroke: hottest > 380 ? 0.004 : 0.001, columns: { temperature: [AROUND] }, ends: { hottest: [AROUND, hottest] },
  } as unknown as Run;
}

test("a load, and a thicker wire that gets as hot as before, end an excess of stress", async () => {
  const before = lift({});
  assert.deepEqual(dangersOf(before).map(({ kind }) => kind), ["stress"]);
  const asked: Changes[] = [];
  const found = [];
  for (const knob of knobsOf(entriesOf(FORM), "stress")) {
    found.push(await findCure(knob, before.alarms[0]!, before, (changes) => Promise.resolve((asked.push(changes), lift(changes)))));
  }
  assert.equal(found[0]?.words, "mass 300 g"); // 0.5 kg · 172 / 277.6 MPa = 309.8 g, rounded down
  assert.equal(found[1]?.words, "diameter 0.2 mm, heated to the same temperature"); // 0.15 mm · √1.61 = 0.19 mm
  assert.ok(Math.abs((found[1]?.run.ends["hottest"]?.[1] ?? 0) - 390) < 3);
  assert.equal(found[2], null); // the stress of a hanging weight does not fall with the heat
  assert.ok(found.every((one) => !one || dangersOf(one.run).length === 0));
  assert.ok(asked.length <= 1 + 3 + 5);
});

test("a change that stops the motion, or that exceeds another limit, is no cure and does not help", async () => {
  const hot = lift({ "mechanism.mass": "100 g", "drive.waveform.high": "4.2 W" });
  const [heat] = knobsOf(entriesOf(FORM), "temperature");
  const still = await findCure(heat!, hot.alarms[0]!, hot, () => Promise.resolve({ ...lift({ "mechanism.mass": "100 g" }), stroke: 0.001 } as Run));
  assert.equal(still, null);
  const other = await findCure(heat!, hot.alarms[0]!, hot, () => Promise.resolve(lift({})));
  assert.equal(other, null);
  assert.equal(gainOf(lift({ "mechanism.mass": "100 g" }), { ...lift({}), stroke: 1 } as Run, "motion"), 0);
});
