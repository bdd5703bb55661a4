// The model that is stepped: of the page where it has it, else made by the server.

import { findStepped, isStatic } from "../engine/local.ts";
import { predictInputs, type Changes } from "../engine/inputs.ts";
import { readModule, type ModelAnswer } from "../engine/served.ts";
import type { Scenario } from "../engine/types.ts";
import type { Source } from "../engine/worker.ts";
import { call } from "../lib/api.ts";
import { handleOf, kindOf } from "./handles.ts";

export interface Model {
  text: string;
  scenario: Scenario;
  /** Controls that differ from the document of the scenario. */
  changes: Changes;
  /** Where its module lies, or the module itself. */
  from: Source;
  /** Of the document's run [s]. */
  duration: number;
}

const made = new Map<string, Model>();

export async function findModel(text: string): Promise<Model> {
  if (isStatic()) {
    const { scenario, changes, address } = await findStepped(text);
    return { text, scenario, changes, from: address, duration: predictInputs(scenario, changes)[scenario.places.duration]! };
  }
  const known = made.get(text);
  if (known) return known;
  const path = handleOf(kindOf(text))?.path;
  const answer = await call<ModelAnswer>("model", { text, changes: {}, paths: path ? [path] : [] }, "model");
  const { scenario } = answer;
  const found = { text, scenario, changes: {}, from: readModule(answer), duration: Number(scenario.inputs[scenario.places.duration]) };
  made.set(text, found);
  return found;
}
