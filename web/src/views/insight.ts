// One sentence on what limits a run, from its balance of time, and what another run says about a remedy.

import { difference, digits, toShown } from "../lib/numbers.ts";
import type { Run } from "../lib/types.ts";
import { dangersOf } from "./cures.ts";
import { cycleOf, measureDeviation, energyOf, howOf, peakOf, measureTravel } from "./results.ts";

const PRINTED: Record<string, string> = { degC: "°C", deg: "°" };
const printed = (unit: string): string => PRINTED[unit] ?? unit;

const seconds = (time: number): string => `${digits(time, 2)} s`;
const percent = (share: number): string => `${(100 * share).toFixed(0)} %`;

/** A length of the coordinate in its unit. */
function way(run: Run, size: number): string {
  const how = run.outputs[run.coordinate];
  return how ? `${digits(difference(size, how), 2)} ${printed(how.display_unit)}`.replace(" °", "°") : digits(size, 2);
}

function hottest(run: Run): string {
  const [peak, how] = [peakOf(run, "hottest"), howOf(run, "hottest")];
  return peak === null || !how ? "" : `${digits(toShown(peak, how), 3)} ${printed(how.display_unit)}`;
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
  if (!cycle || cycle.up === null) return { aim: "motion", sentence: `The mechanism hardly moves: the wire reaches only ${hottest(run)}, too cold for a full transformation.` };
  const { up, down, wait } = cycle;
  if (cycle.isOfCurve) return ofSeveral(run, up, down);
  if (down === null) return { aim: "return", sentence: `The actuator extends in ${seconds(up)} but does not return within this run.` };
  const share = down / (up + down);
  if (share < 0.5) return { aim: "heating", sentence: `Heating takes ${percent(1 - share)} of the cycle: ${seconds(up)} to contract, ${seconds(down)} to return.` };
  const idle = wait !== null && wait > 0.2 * down ? ` (including ${seconds(wait)} of cooling from ${hottest(run)} before it moves)` : "";
  return { aim: "cooling", sentence: `Cooling takes ${percent(share)} of the cycle: ${seconds(down)} to return${idle}, ${seconds(up)} to contract.` };
}

/** Of elements that pull against each other: what they turn into heat. */
function ofSeveral(run: Run, up: number, down: number | null): Insight {
  const back = down === null ? "no return within this run" : `return in ${seconds(down)}`;
  const share = run.energy.efficiency?.at(-1);
  const heat = share ? `; efficiency ${digits(100 * share, 2)} %` : "";
  return { aim: null, sentence: `10 % to 90 % of the stroke in ${seconds(up)}, ${back}${heat}.` };
}

function ofLoop(run: Run, { rms, cooling }: { rms: number; cooling: number }): Insight {
  const [share, action] = cooling >= 0.5 ? [cooling, "cool"] : [1 - cooling, "heat"];
  const size = `${way(run, rms)} RMS, ${percent(rms / (run.stroke || rms))} of the stroke`;
  return { aim: "error", sentence: `The position error is ${size}; ${percent(share)} of the squared error arises while the wire must ${action}.` };
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

/** A smaller change than this fraction is no effect. */
const SAME = 0.005;

/** Effect of a remedy: larger is better, 0 if it does not help or exceeds another limit. */
export function gainOf(before: Run, after: Run, aim: Aim): number {
  const [then, now] = [findJudged(before, aim), findJudged(after, aim)];
  if (now === null || now <= 0 || dangersOf(after).length > dangersOf(before).length) return 0;
  if (aim === "return") return 1 / now;
  const gain = aim === "motion" ? now / (then || now) - 1 : (then ?? 0) / now - 1;
  return gain > SAME ? gain : 0;
}

/** What a remedy brings, told from a run of it; empty if it brings nothing. */
export function writePromise(before: Run, after: Run, aim: Aim, words: string, wires = 1): string {
  const [then, now] = [findJudged(before, aim), findJudged(after, aim)];
  if (now === null) return "";
  if (aim === "return") return `With ${words}, the actuator returns in about ${seconds(now)}.`;
  if (then === null || then === 0) return "";
  if (aim === "motion") return now > 1.2 * then ? `With ${words}, the stroke is about ${way(after, now)}.` : "";
  if (now > 0.95 * then) return "";
  if (aim === "error") return `With ${words}, the error is about ${way(after, now)}.`;
  const action = aim === "heating" ? "contract" : "return";
  const cost = (wires * (energyOf(after) ?? 0)) / (energyOf(before) ?? 1);
  const price = Math.abs(cost - 1) > 0.05 && cost > 0 ? `, for ${digits(cost, 2)} times the energy` : "";
  return `With ${words}, the actuator would ${action} in about ${seconds(now)}, ${digits(then / now, 2)} times as fast${price}.`;
}
