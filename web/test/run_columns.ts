// Runs a scenario of a static page in Node.js: node run_columns.mjs FOLDER NAME '{"path": value}'
// prints what came of it as JSON.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { RunModule } from "../src/engine/march.ts";
import { runScenario } from "../src/engine/run.ts";
import type { Scenario } from "../src/engine/types.ts";

const [folder = "", name = "", ...all] = process.argv.slice(2);
const scenario = JSON.parse(readFileSync(join(folder, `${name}.json`), "utf-8")) as Scenario;
const module = new RunModule(new WebAssembly.Module(readFileSync(join(folder, scenario.module))), scenario.layout);
for (const changes of all) {
  let found: unknown;
  try {
    const run = runScenario(scenario, module, JSON.parse(changes) as Record<string, number>, scenario.text);
    const again = runScenario(scenario, module, JSON.parse(changes) as Record<string, number>, scenario.text);
    const columns = Object.fromEntries(Object.entries(run.columns).map(([key, one]) => [key, [...one]]));
    found = { ...run, times: [...run.times], columns, profiles: null, parameters: null, seconds: again.seconds };
  } catch (error) {
    found = { refused: error instanceof Error ? error.message : String(error) };
  }
  console.log(JSON.stringify(found));
}
