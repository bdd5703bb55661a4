// What the challenge asks for, and the score of what was held.

import { toShown } from "../lib/numbers.ts";
import type { Run } from "../lib/types.ts";
import { formatGeneral } from "../views/formulas.ts";

/** Share of the target within which a position counts as held. */
const BAND = 0.05;
/** Share of the stroke that is to be held: it must be reached on the steep part of the loop. */
const WAY = 0.25;

export interface Target {
  /** Position to hold, and how far from it still counts [SI]. */
  at: number;
  band: number;
  /** In words, such as "3 mm". */
  words: string;
}

export interface Score {
  /** 0 to 100: share of the time within the band. */
  points: number;
  /** Root mean square of the error [SI]. */
  rms: number;
}

/** A quarter of the stroke of a run, as a round number; null if nothing moves. */
export function chooseTarget(now: Run): Target | null {
  const how = now.outputs[now.coordinate];
  const x = now.columns[now.coordinate];
  if (!how || !x?.length || !(now.stroke > 0) || how.offset) return null;
  const [low, high] = now.ends[now.coordinate]!;
  const start = x[0]!;
  const way = high - start > start - low ? high - start : low - start;
  const wish = toShown(start + WAY * way, how);
  const shown = Number(wish.toPrecision(1));
  if (!shown) return null;
  const at = shown / how.factor;
  return { at, band: Math.abs(BAND * at), words: `${formatGeneral(shown, 3)} ${how.display_unit === "deg" ? "°" : how.display_unit}` };
}

/** Score of positions over time, each of which holds until the next one. */
export function scoreHold(times: ArrayLike<number>, positions: ArrayLike<number>, { at, band }: Pick<Target, "at" | "band">): Score {
  let [all, inside, squares] = [0, 0, 0];
  for (let k = 0; k + 1 < times.length; k++) {
    const [length, error] = [times[k + 1]! - times[k]!, positions[k]! - at];
    all += length;
    squares += error * error * length;
    if (Math.abs(error) <= band) inside += length;
  }
  return all > 0 ? { points: Math.round((100 * inside) / all), rms: Math.sqrt(squares / all) } : { points: 0, rms: NaN };
}
