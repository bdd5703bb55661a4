// When a margin, linear between samples, is above zero; see martensite.simulate.alarms.

import { MOST_SPANS } from "../engine/constants.ts";
import { fillRow } from "./formulas.ts";

export type Numbers = ArrayLike<number>;
export type Span = [begin: number, end: number];

export interface Excursion {
  first: number;
  duration: number;
  /** Number of the sample with the largest margin. */
  worst: number;
}

/** Null if it never is. */
export function findExcursion(times: Numbers, margins: Numbers): Excursion | null {
  let worst = 0;
  for (let k = 1; k < margins.length; k++) if (margins[k]! > margins[worst]!) worst = k;
  if (!(margins[worst]! > 0)) return null;
  let first = margins[0]! > 0 ? times[0]! : null;
  let duration = 0;
  for (let k = 1; k < margins.length; k++) {
    const above = shareAbove(margins[k - 1]!, margins[k]!) * (times[k]! - times[k - 1]!);
    if (first === null && margins[k]! > 0) first = times[k]! - above;
    duration += above;
  }
  return { first: first ?? times[0]!, duration, worst };
}

function shareAbove(begin: number, end: number): number {
  if (begin > 0 && end > 0) return 1;
  const high = Math.max(begin, end);
  return high > 0 ? high / (high - Math.min(begin, end)) : 0;
}

/** Spans in which a margin is above zero. */
export function findSpans(times: Numbers, margins: Numbers): Span[] {
  const found: Span[] = [];
  let begin = margins[0]! > 0 ? times[0]! : null;
  for (let k = 1; k < margins.length; k++) {
    const [t0, t1, m0, m1] = [times[k - 1]!, times[k]!, margins[k - 1]!, margins[k]!];
    if (m0 > 0 === m1 > 0) continue;
    const crossed = t0 + ((t1 - t0) * m0) / (m0 - m1);
    if (begin !== null) found.push([begin, crossed]);
    begin = begin === null ? crossed : null;
  }
  if (begin !== null) found.push([begin, times[times.length - 1]!]);
  return limitSpans(found);
}

export function limitSpans(spans: Span[]): Span[] {
  if (spans.length <= MOST_SPANS) return spans;
  return [...spans.slice(0, MOST_SPANS - 1), [spans[MOST_SPANS - 1]![0], spans.at(-1)![1]]];
}

/** Distance of every value from the farthest that it had before. */
export function farthestChanges(values: Numbers): Float64Array {
  let low = values[0]!;
  let high = low;
  return fillRow(values.length, (k) => {
    const value = values[k]!;
    low = Math.min(low, value);
    high = Math.max(high, value);
    return Math.max(high - value, value - low);
  });
}
