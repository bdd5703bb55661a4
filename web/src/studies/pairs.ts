// Printed and computed values of claims, and where they are drawn.

import type { Claim, Verdict } from "./types.ts";
import { rankVerdict } from "./verdict.tsx";

/** A claim with both values; the printed value of a misprinted equation is its result. */
export interface Pair {
  claim: Claim;
  printed: number;
  computed: number;
}

/** Errors in print first, because readers of the source need them most. */
const FIRST: Verdict[] = ["misprint", "self-contradictory", "disagrees"];
const rank = (verdict: Verdict): number => (FIRST.includes(verdict) ? FIRST.indexOf(verdict) : FIRST.length + rankVerdict(verdict));

/** Claims whose values can be drawn, errors in print first. */
export function listPairs(claims: Claim[]): Pair[] {
  const pairs = claims.flatMap((claim) => {
    const value = claim.published ?? claim.as_printed;
    return value === null || claim.computed === null ? [] : [{ claim, printed: value, computed: claim.computed }];
  });
  return pairs.sort((a, b) => rank(a.claim.verdict) - rank(b.claim.verdict));
}

/** Largest drawn factor between the values. */
export const MOST = 10;
/** Place of a computed value on the axis, -1 to 1: 0 is the printed value, ±1 a factor of ten or more. */
export function placeOn(computed: number, value: number): number {
  if (computed === value) return 0;
  const factor = computed / value;
  if (!(factor > 0) || !Number.isFinite(factor)) return computed < value ? -1 : 1;
  const size = Math.min(Math.abs(Math.log10(factor)) / Math.log10(MOST), 1);
  return Math.sign(factor - 1) * Math.sqrt(size);
}
