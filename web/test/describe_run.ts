// Makes runs as the page draws them: node describe_run.mjs FILE, with columns and what Python says of a scenario.

import { readFileSync } from "node:fs";
import type { RunCore } from "../src/engine/types.ts";
import { describeRun, type Described } from "../src/views/run.ts";

interface Asked {
  core: RunCore & { parameters: Record<string, number | string> };
  page: Described;
}

const { asked } = JSON.parse(readFileSync(process.argv[2] ?? "", "utf-8")) as { asked: Asked[] };
const floats = (values: ArrayLike<number>): Float64Array => Float64Array.from(values);
const table = (columns: Record<string, ArrayLike<number>>) => Object.fromEntries(Object.entries(columns).map(([name, column]) => [name, floats(column)]));
const found = asked.map(({ core, page }) => {
  const columns = table(core.columns);
  const track = core.track && { times: floats(core.track.times), columns: table(core.track.columns), weights: floats(core.track.weights) };
  const parameters = Object.fromEntries(Object.entries(core.parameters).map(([path, value]) => [path, Number(value)]));
  return describeRun({ ...core, times: floats(core.times), columns, track, parameters }, page);
});
console.log(JSON.stringify(found));
