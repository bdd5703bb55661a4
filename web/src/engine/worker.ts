// Runs scenarios beside the page: one after the other, each on the module of its structure.

import { Refusal } from "../lib/refusal.ts";
import { fetchModule } from "./files.ts";
import { RunModule } from "./march.ts";
import { runScenario } from "./run.ts";
import { beginStepping, type Span, type Steps } from "./stepping.ts";
import type { RunCore, Scenario } from "./types.ts";

/** A module: its address, or its bytes. */
export type Source = string | Uint8Array;

export interface Asked {
  id: number;
  from: Source;
  /** Once for each scenario. */
  scenario: Scenario | null;
  name: string;
  changes: Record<string, number>;
  text: string;
}

/** A module that will be asked for. */
export interface Expected {
  fetch: string;
}

/** A model that goes on by spans of time: put at rest, then stepped with all drives at levels, in SI. */
export type AskedStep =
  | { begin: { from: Source; scenario: Scenario }; changes: Record<string, number> }
  | { length: number; parts: number; levels: number[]; changes: Record<string, number> | null };

/** `took`: time of the calculation [ms]. */
export type Stepped = (Span & { took: number }) | { refused: string };

export type Answered = { id: number; run: RunCore } | { id: number; refused: string; kind: string };

const scenarios = new Map<string, Scenario>();
const modules = new Map<string, Promise<RunModule>>();

const compiled = new Map<string, Promise<WebAssembly.Module>>();

/** A module, fetched and compiled once. */
function compileOnce(address: string): Promise<WebAssembly.Module> {
  const known = compiled.get(address) ?? fetchModule(address);
  compiled.set(address, known);
  known.catch(() => compiled.delete(address));
  return known;
}

async function load(from: Source, scenario: Scenario): Promise<RunModule> {
  return new RunModule(await (typeof from === "string" ? compileOnce(from) : WebAssembly.compile(from.slice())), scenario.layout);
}

async function answer(asked: Asked): Promise<Answered> {
  if (asked.scenario) scenarios.set(asked.name, asked.scenario);
  const scenario = scenarios.get(asked.name)!;
  try {
    if (!modules.has(asked.name)) modules.set(asked.name, load(asked.from, scenario));
    const run = runScenario(scenario, await modules.get(asked.name)!, asked.changes, asked.text);
    return { id: asked.id, run };
  } catch (error) {
    modules.delete(asked.name); // a module that failed is made anew
    const said = error instanceof Error ? error.message : String(error);
    return { id: asked.id, refused: said, kind: error instanceof Refusal ? error.kind : "failed" };
  }
}

let stepping: Steps | null = null;

async function step(asked: AskedStep): Promise<Stepped> {
  const begun = performance.now();
  const nothing = { times: new Float64Array(), rows: new Float64Array(), said: "" };
  try {
    if ("begin" in asked) {
      const { scenario, from } = asked.begin;
      stepping = beginStepping(scenario, await load(from, scenario), asked.changes);
      return { ...nothing, took: performance.now() - begun };
    }
    if (asked.changes) stepping!.change(asked.changes);
    return { ...stepping!.go(asked.length, asked.parts, asked.levels), took: performance.now() - begun };
  } catch (error) {
    return { refused: error instanceof Error ? error.message : String(error) };
  }
}

onmessage = async (event: MessageEvent<Asked | AskedStep | Expected>) => {
  if ("fetch" in event.data) return void compileOnce(event.data.fetch).catch(() => undefined); // said when it is asked for
  if (!("id" in event.data)) return postMessage(await step(event.data));
  const found = await answer(event.data);
  const arrays = "run" in found ? [found.run, found.run.track].flatMap((one) => (one ? [one.times, ...Object.values(one.columns)] : [])) : [];
  if ("run" in found) arrays.push(...Object.values(found.run.profiles));
  postMessage(found, { transfer: arrays.map((one) => one.buffer) });
};
