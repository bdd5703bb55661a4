// Fits beside the page, one each: it tells of every better point with all that is known there.

import { fetchModule } from "../engine/files.ts";
import { RunModule } from "../engine/march.ts";
import type { Scenario } from "../engine/types.ts";
import { descendSquares, type Descent } from "./descent.ts";
import { FitModel } from "./model.ts";
import { toShare, type Curves, type Problem } from "./problem.ts";

export interface AskedFit {
  /** Address of the module. */
  address: string;
  scenario: Scenario;
  problem: Problem;
}

/** `apart`: see `FitModel`. */
export type ToldFit = { now: Descent<Curves>; apart: number } | { refused: string };

onmessage = async ({ data }: MessageEvent<AskedFit>) => {
  try {
    postMessage(await searchNumbers(data));
  } catch (error) {
    postMessage({ refused: error instanceof Error ? error.message : String(error) } satisfies ToldFit);
  }
};

async function searchNumbers({ address, scenario, problem }: AskedFit): Promise<ToldFit> {
  const module = new RunModule(await fetchModule(address), scenario.layout);
  const model = new FitModel(scenario, module, problem);
  const counted = (now: Descent<Curves>): ToldFit => ({ now: { ...now, runs: now.runs + model.runs }, apart: model.apart });
  const begin = problem.free.map((free) => toShare(free, free.start));
  return counted(descendSquares((shares) => model.evaluate(shares), begin, (now) => postMessage(counted(now)), model.apart));
}
