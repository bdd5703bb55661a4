// Steps a scenario of a static page in Node.js, span by span, with its own drive held over each:
// node step_columns.mjs FOLDER NAME SPAN prints the largest differences from its run, as shares of
// ranges, and the time that a span takes.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { readSignal } from "../src/engine/drives.ts";
import { RunModule } from "../src/engine/march.ts";
import { readInputs, runScenario } from "../src/engine/run.ts";
import { beginStepping } from "../src/engine/stepping.ts";
import type { Scenario } from "../src/engine/types.ts";

const [folder = "", name = "", span = ""] = process.argv.slice(2);
const scenario = JSON.parse(readFileSync(join(folder, `${name}.json`), "utf-8")) as Scenario;
const module = new RunModule(new WebAssembly.Module(readFileSync(join(folder, scenario.module))), scenario.layout);
const run = runScenario(scenario, module, {}, scenario.text);
const { all, duration } = readInputs(scenario, {});
const stepping = beginStepping(scenario, module, {});
const count = Math.round(duration / Number(span));
const every = Math.round(Number(span) / (duration / (run.samples - 1)));
const given = scenario.layout.march === "given";
/** A loop reads its reference at the end of a period. */
const middles = Float64Array.from({ length: count }, (_, k) => (k + (given ? 1 + 1e-9 : 0.5)) * Number(span));
const held = (name: string): boolean => !given || name.startsWith("reference");
const levels = scenario.places.drives.map((drive) => (held(drive.name) ? readSignal(scenario, drive, all, middles) : middles.map(() => NaN)));
const width = scenario.names.length;
const rows: number[][] = [];
const took: number[] = [];
for (let k = 0; k < count; k++) {
  const begun = performance.now();
  const found = stepping.go(Number(span), 1, levels.map((one) => one[k]!));
  took.push(performance.now() - begun);
  if (found.said) throw new Error(found.said);
  for (let at = 0; at < found.times.length; at++) rows.push([...found.rows.slice(at * width, (at + 1) * width)]);
}
const apart = scenario.judged.map(([output, least]) => {
  const column = run.columns[scenario.names[output]!]!;
  const range = Math.max(column.reduce((a, b) => Math.max(a, b)) - column.reduce((a, b) => Math.min(a, b)), least);
  let most = 0;
  rows.forEach((row, k) => (most = Math.max(most, Math.abs(row[output]! - column[k * every]!) / range)));
  return [scenario.names[output], most];
});
took.sort((a, b) => a - b);
console.log(JSON.stringify({ apart: Object.fromEntries(apart), rows: rows.length, median: took[took.length >> 1], slow: took[Math.floor(0.95 * took.length)] }));
