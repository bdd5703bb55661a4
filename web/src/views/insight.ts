// One sentence on what limits a run, from its balance of time, and what another run says about a remedy.

import { difference, digits, toShown } from "../lib/numbers.ts";
import type { Run } from "../lib/types.ts";
import { cycleOf, measureDeviation, energyOf, howOf, peakOf, measureTravel } from "./results.ts";

const PRINTED: Record<string, string> = { degC: "°C", deg: "°" };
const printed = (unit: string): string => PRINTED[unit] ?? unit;

const seconds = (time: number): string => `${digits(time, 2)} s`;
const percent = (share: number): string => `${(100 * share).toFixed(0)} %`;

/** A length of the coordinate in its unit. */
function way(run: Run, size: number): string {
  const how = run.outputs[run.coordinate];
  return how ? `${digits(difference(size, how), 2)} ${printed(how.shown)}`.replace(" °", "°") : digits(size, 2);
}

function hottest(run: Run): string {
  const [peak, how] = [peakOf(run, "hottest"), howOf(run, "hottest")];
  return peak === null || !how ? "" : `${digits(toShown(peak, how), 3)} ${printed(how.shown)}`;
}

/** What of a run a remedy should make smaller: its cycle, or the error of its loop. */
export type Aim = "cooling" | "heating" | "error" | "return" | "motion";

export interface Insight {
  sentence: string;
  /** Null where several elements work against each other: no remedy is known to be one. */
  aim: Aim | null;
}

/** What takes the time of this run; null where nothing is heated. */
export function insightOf(run: Run): Insight | null {
  if (energyOf(run) === null) return null;
  const error = measureDeviation(run);
  if (error) return ofLoop(run, error);
  const cycle = cycleOf(run);
  if (!cycle && measureTravel(run)) return null;
  if (!cycle || cycle.up === null) return { aim: "motion", sentence: `It hardly moves: the wire gets ${hottest(run)} hot, and that does not transform it far.` };
  const { up, down, wait } = cycle;
  if (cycle.isOfCurve) return ofSeveral(run, up, down);
  if (down === null) return { aim: "return", sentence: `It does not come back within this run: it takes ${seconds(up)} out, and is not yet down when the run ends.` };
  const share = down / (up + down);
  if (share < 0.5) return { aim: "heating", sentence: `Heating takes ${percent(1 - share)} of the cycle: ${seconds(up)} out, and ${seconds(down)} back.` };
  const idle = wait !== null && wait > 0.2 * down ? ` (the first ${seconds(wait)} from ${hottest(run)} without moving)` : "";
  return { aim: "cooling", sentence: `Cooling takes ${percent(share)} of the cycle: ${seconds(down)} back${idle}, ${seconds(up)} out.` };
}

/** Of elements that pull against each other: what they turn into heat. */
function ofSeveral(run: Run, up: number, down: number | null): Insight {
  const back = down === null ? "it does not come back within this run" : `${seconds(down)} back`;
  const share = run.energy.efficiency?.at(-1);
  const heat = share ? `; of the electrical energy ${digits(100 * share, 2)} % become work` : "";
  return { aim: null, sentence: `From 10 % to 90 % of the stroke it takes ${seconds(up)}, ${back}${heat}.` };
}

function ofLoop(run: Run, { rms, cooling }: { rms: number; cooling: number }): Insight {
  const [share, action] = cooling >= 0.5 ? [cooling, "cool"] : [1 - cooling, "heat"];
  const size = `${way(run, rms)} RMS, ${percent(rms / (run.stroke || rms))} of the stroke`;
  return { aim: "error", sentence: `The position is off by ${size}; ${percent(share)} of the squared error arise while the wire has to ${action}.` };
}

/** Time or error that is judged [SI]; null if the run does not show it. */
export function findJudged(run: Run, aim: Aim): number | null {
  if (aim === "error") return measureDeviation(run)?.rms ?? null;
  if (aim === "motion") return run.stroke;
  const cycle = cycleOf(run);
  if (!cycle) return null;
  if (aim === "heating") return cycle.up;
  return cycle.down;
}

/** What a remedy brings, told from a run of it; empty if it brings nothing. */
export function writePromise(before: Run, after: Run, aim: Aim, words: string, wires = 1): string {
  const [then, now] = [findJudged(before, aim), findJudged(after, aim)];
  if (now === null) return "";
  if (aim === "return") return `With ${words}, it comes back in about ${seconds(now)}.`;
  if (then === null || then === 0) return "";
  if (aim === "motion") return now > 1.2 * then ? `With ${words}, it moves by about ${way(after, now)}.` : "";
  if (now > 0.95 * then) return "";
  if (aim === "error") return `With ${words}, it would be off by about ${way(after, now)}.`;
  const action = aim === "heating" ? "go out" : "come back";
  const cost = (wires * (energyOf(after) ?? 0)) / (energyOf(before) ?? 1);
  const price = Math.abs(cost - 1) > 0.05 && cost > 0 ? `, for ${digits(cost, 2)} times the energy` : "";
  return `With ${words}, it would ${action} in about ${seconds(now)}, ${digits(then / now, 2)} times as fast${price}.`;
}
