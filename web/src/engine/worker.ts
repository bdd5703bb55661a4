// Runs scenarios beside the page: one after the other, each on the module of its structure.

import { Refusal } from "../lib/refusal.ts";
import { RunModule } from "./march.ts";
import { runScenario } from "./run.ts";
import type { RunCore, Scenario } from "./types.ts";

export interface Asked {
  id: number;
  /** Address of the module. */
  address: string;
  /** Once for each scenario. */
  scenario: Scenario | null;
  name: string;
  changes: Record<string, number>;
  text: string;
}

export type Answered = { id: number; run: RunCore } | { id: number; refused: string; kind: string };

const scenarios = new Map<string, Scenario>();
const modules = new Map<string, Promise<RunModule>>();

async function load(asked: Asked, scenario: Scenario): Promise<RunModule> {
  const response = await fetch(asked.address);
  if (!response.ok) throw new Refusal(`The page cannot be read further: ${scenario.module} is missing.`, "lost", response.status);
  return new RunModule(await WebAssembly.compile(await response.arrayBuffer()), scenario.layout);
}

async function answer(asked: Asked): Promise<Answered> {
  if (asked.scenario) scenarios.set(asked.name, asked.scenario);
  const scenario = scenarios.get(asked.name)!;
  try {
    if (!modules.has(asked.name)) modules.set(asked.name, load(asked, scenario));
    const run = runScenario(scenario, await modules.get(asked.name)!, asked.changes, asked.text);
    return { id: asked.id, run };
  } catch (error) {
    modules.delete(asked.name); // a module that failed is made anew
    const said = error instanceof Error ? error.message : String(error);
    return { id: asked.id, refused: said, kind: error instanceof Refusal ? error.kind : "failed" };
  }
}

onmessage = async (event: MessageEvent<Asked>) => {
  const found = await answer(event.data);
  const arrays = "run" in found ? [found.run.times, ...Object.values(found.run.columns), ...Object.values(found.run.profiles)] : [];
  postMessage(found, { transfer: arrays.map((one) => one.buffer) });
};
