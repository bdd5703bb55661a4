// Runs that the page makes of a scenario of the server, once the server has sent its module.

import { call, superseded } from "../lib/api.ts";
import { host } from "../lib/host.ts";
import type { Run } from "../lib/types.ts";
import { findKnown, readChanges, writeChanged } from "./documents.ts";
import { drawRun } from "./drawn.ts";
import { predictInputs, type Changes } from "./inputs.ts";
import { isStatic, runLocally } from "./local.ts";
import type { Scenario } from "./types.ts";

interface Served {
  scenario: Scenario;
  module: Uint8Array;
}

/** A model of the server; its module is in base 64. */
export interface ModelAnswer {
  scenario: Scenario;
  module: string;
}

export const readModule = ({ module }: ModelAnswer): Uint8Array => Uint8Array.from(atob(module), (letter) => letter.charCodeAt(0));

let served: Served | null = null;
let count = 0;
/** Controls that were moved, of documents that differ in numbers only. */
let moved: { skeleton: string; paths: Set<string>; refused: boolean } = { skeleton: "", paths: new Set(), refused: false };

const skeletonOf = (text: string): string => text.replace(/[-+.\d]+(e[-+]?\d+)?/g, "");

/** Get ready for more changes of the same controls. */
export async function expectChanges(text: string, paths: string[]): Promise<void> {
  if (isStatic() || host || !paths.length) return;
  const skeleton = skeletonOf(text);
  if (moved.skeleton !== skeleton) moved = { skeleton, paths: new Set(), refused: false };
  const mine = moved;
  if (mine.refused || paths.every((path) => mine.paths.has(path))) return;
  paths.forEach((path) => mine.paths.add(path));
  try {
    const answer = await call<ModelAnswer>("model", { text, changes: {}, paths: [...mine.paths], ready: true }, "engine");
    if (moved === mine) served = { scenario: { ...answer.scenario, name: `served ${++count}` }, module: readModule(answer) };
  } catch (error) {
    if (!superseded(error)) mine.refused = true; // the server runs it
  }
}

/** The run of a document with changes; null if only the server can make it. */
export function runServed(document: string, changes: Record<string, unknown>): Promise<Run> | null {
  if (!served) return null;
  const { scenario, module } = served;
  let text = "";
  let known: Changes = {};
  try {
    text = writeChanged(document, changes);
    known = readChanges(scenario, findKnown({ version: "", scenarios: [{ ...scenario, file: "" }] }, text).written);
    predictInputs(scenario, known);
  } catch {
    return null; // the server says why, or runs it
  }
  return runLocally(scenario, known, text, module).then(
    (core) => ({ ...drawRun(scenario, core), cautions: core.cautions }),
    (error: unknown) => {
      if (superseded(error)) throw error;
      served = null;
      return call<Run>("run", { text: document, changes }, "run");
    },
  );
}
