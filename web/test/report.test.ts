import assert from "node:assert/strict";
import { test } from "node:test";
import type { Run } from "../src/lib/types.ts";
import { unpacked } from "../src/lib/pack.ts";
import { fillReport, PLACE, type ReportData } from "../src/report/data.ts";

const ROWS = 20_001;
const noise = Array.from({ length: ROWS }, (_, k) => Math.sin(k * k));
const names = Array.from({ length: 12 }, (_, k) => `c${k}`);
const run = {
  text: "", times: noise.map((_, k) => k / 100), columns: { ...Object.fromEntries(names.map((name) => [name, noise])), unseen: noise },
  outputs: { c0: {}, unseen: {} }, traces: [{ ports: { a: names } }], loops: [], alarms: [], phase: { ports: {} },
  stretches: { a: [[1, 0, 9000], [-1, 9000, ROWS - 1]] }, energy: { courses: [], efficiency: null, sentence: "" }, scene: {},
} as unknown as Run;
const data: ReportData = { run, pins: [{ id: 1, name: "1", run }], notes: "", made: "", differences: [], sections: [], parts: {} };

test("a report of long runs stays small, with its ends and only with what is drawn", async () => {
  const page = await fillReport(`before${PLACE}</script>after`, data);
  assert.ok(page.length < 300_000);
  const found = JSON.parse(await unpacked(page.slice(6 + PLACE.length, -"</script>after".length), "deflate")) as ReportData;
  for (const { times, columns, stretches } of [found.run, found.pins[0]!.run]) {
    assert.ok(times.length > 100 && times.length <= 1501);
    assert.deepEqual([times[0], times.at(-1)], [0, 200]);
    assert.deepEqual(Object.keys(columns), names);
    assert.ok(names.every((name) => columns[name]?.length === times.length));
    const [[, , first] = [], [, second, last] = []] = stretches["a"] ?? [];
    assert.equal(first, second);
    assert.equal(last, times.length - 1);
  }
});

test("a page without a place for the data is refused", async () => {
  await assert.rejects(fillReport("", data));
});
