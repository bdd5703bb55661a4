// Runs a scenario of a static page in Node.js: node run_columns.mjs FOLDER NAME '{"path": value}'
// prints what came of it as JSON. Values are in SI, or all as the document has them: texts and lists.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fillForm, findKnown, readChanges, writeChanged } from "../src/engine/documents.ts";
import { listControls, predictInputs, type Changes } from "../src/engine/inputs.ts";
import { RunModule } from "../src/engine/march.ts";
import { runScenario } from "../src/engine/run.ts";
import { describeRun } from "../src/views/run.ts";
import type { Manifest, Scenario } from "../src/engine/types.ts";

const [folder = "", name = "", ...all] = process.argv.slice(2);
const scenario = JSON.parse(readFileSync(join(folder, `${name}.json`), "utf-8")) as Scenario;
const module = new RunModule(new WebAssembly.Module(readFileSync(join(folder, scenario.module))), scenario.layout);
const manifest = JSON.parse(readFileSync(join(folder, "manifest.json"), "utf-8")) as Manifest;

/** A document with changes, and what they are in SI. */
function understand(given: Record<string, unknown>): { text: string; changes: Changes } {
  if (Object.values(given).every((one) => typeof one === "number")) return { text: scenario.text, changes: given as Changes };
  const text = writeChanged(scenario.text, given);
  return { text, changes: readChanges(scenario, findKnown(manifest, text).written) };
}

for (const given of all) {
  let found: unknown;
  try {
    const { text, changes } = understand(JSON.parse(given) as Record<string, unknown>);
    const run = runScenario(scenario, module, changes, text);
    const again = runScenario(scenario, module, changes, text);
    const columns = Object.fromEntries(Object.entries(run.columns).map(([key, one]) => [key, [...one]]));
    const form = fillForm(scenario, text, changes, predictInputs(scenario, changes));
    const rows = Object.fromEntries(listControls(form.sections).flatMap((one) => (one.sort === "row" ? [[one.path, one.value]] : [])));
    const { key, ends, alarms } = describeRun(run, scenario);
    found = { ...run, track: null, key, ends, alarms, times: [...run.times], columns, profiles: null, parameters: null, seconds: again.seconds, rows };
  } catch (error) {
    found = { refused: error instanceof Error ? error.message : String(error) };
  }
  console.log(JSON.stringify(found));
}
