// How well a log determines the numbers of a fit: martensite/search/uncertainty.py and identifiability.py, for few
// numbers and derivatives by differences.
//
//   s² = Σ r²/(n - p),   covariance = s² (JᵀJ)⁻¹,   z ± t(0.975, n - p) error
//
// Directions that J does not determine are left out, and numbers that take part in them have no interval. Residuals
// that follow each other say as much as fewer; `widened` counts those.

import { decomposeSymmetric, dot, multiplyColumns } from "./matrices.ts";
import { PRECISION } from "./descent.ts";

const TURNED = 1e-2;
const CONFOUNDED = 0.95;

export interface Uncertainty {
  /** Standard errors in shares of the ranges; infinite where nothing determines a number. */
  errors: number[];
  correlation: (number | null)[][];
  /** Half the width of 95 % intervals, in shares, from as many samples as are independent. */
  widened: number[];
  rank: number;
  samples: number;
  /** Independent samples that say as much. */
  effective: number;
  /** Standard deviation of a weighted residual. */
  noise: number;
  /** Sets of numbers that only make up for each other, by place; a number alone has no effect, or hardly any. */
  weak: { places: number[]; exact: boolean; share: number }[];
  /** Pairs that are hardly told apart, with their correlation. */
  confounded: [number, number, number][];
}

export function estimateUncertainty(residuals: Float64Array, jacobian: Float64Array[], lengths: number[], floor = 0): Uncertainty {
  const count = jacobian.length;
  const norms = jacobian.map((one) => Math.sqrt(dot(one, one)));
  const largest = Math.max(...norms, 0);
  const silent = norms.map((norm) => !(norm > 1e-9 * largest));
  const loud = norms.flatMap((_, j) => (silent[j] ? [] : [j]));
  const scaled = multiplyColumns(loud.map((j) => jacobian[j]!)).map((row, a) => row.map((x, b) => x / (norms[loud[a]!]! * norms[loud[b]!]!)));
  const { values, vectors } = decomposeSymmetric(scaled);
  const rank = values.filter((value) => value > PRECISION ** 2 * values[0]!).length;
  const spare = residuals.length - rank;
  // what runs are off by is the least that residuals can tell
  const noise = spare > 0 ? Math.max(floor, Math.sqrt(dot(residuals, residuals) / spare)) : NaN;
  const spread = jacobian.map(() => jacobian.map(() => NaN));
  loud.forEach((i, a) => loud.forEach((j, b) => {
    let sum = 0;
    for (let k = 0; k < rank; k++) sum += (vectors[k]![a]! * vectors[k]![b]!) / values[k]!;
    spread[i]![j] = sum / (norms[i]! * norms[j]!);
  }));
  const lost = norms.map((_, j) => silent[j] || vectors.slice(rank).some((one) => Math.abs(one[loud.indexOf(j)]!) > TURNED));
  const deviations = norms.map((_, j) => (lost[j] ? Infinity : Math.sqrt(spread[j]![j]!)));
  const correlation = spread.map((row, i) => row.map((x, j) => (lost[i] || lost[j] ? null : i === j ? 1 : clipCorrelation(x / (deviations[i]! * deviations[j]!)))));
  const effective = countEffective(residuals, lengths);
  const free = Math.max(1, Math.min(Math.floor(effective) - rank, spare));
  const factor = spare > 0 ? findStudent(free) * Math.sqrt(residuals.length / effective) : Infinity;
  const errors = deviations.map((x) => (spare > 0 ? noise * x : NaN));
  const weak = [
    ...norms.flatMap((_, j) => (silent[j] ? [{ places: [j], exact: true, share: 0 }] : [])),
    ...vectors.slice(rank).map((one) => ({ places: loud.filter((_, a) => Math.abs(one[a]!) > TURNED), exact: true, share: 0 })),
    ...findFaint(jacobian, noise, lost),
  ];
  const confounded: Uncertainty["confounded"] = [];
  for (let i = 0; i < count; i++) for (let j = i + 1; j < count; j++) {
    const value = correlation[i]![j];
    if (typeof value === "number" && Math.abs(value) > CONFOUNDED) confounded.push([i, j, value]);
  }
  return { errors, correlation, widened: errors.map((x) => factor * x), rank, samples: residuals.length, effective, noise, weak, confounded };
}

const clipCorrelation = (x: number): number => Math.min(1, Math.max(-1, x));

/** Directions that are uncertain by more than the whole range of search. */
function findFaint(jacobian: Float64Array[], noise: number, lost: boolean[]): Uncertainty["weak"] {
  const kept = jacobian.flatMap((_, j) => (lost[j] ? [] : [j]));
  const { values, vectors } = decomposeSymmetric(multiplyColumns(kept.map((j) => jacobian[j]!)));
  return values.flatMap((value, k) => {
    if (!(value <= noise * noise)) return [];
    const large = Math.max(...vectors[k]!.map(Math.abs));
    const places = kept.filter((_, a) => Math.abs(vectors[k]![a]!) >= 0.05 * large);
    return [{ places, exact: false, share: noise / Math.sqrt(Math.max(value, 1e-300)) }];
  });
}

/** Samples without memory that say as much: their sum of autocorrelations to the first pair that is not above 0. */
export function countEffective(residuals: Float64Array, lengths: number[]): number {
  const total = dot(residuals, residuals);
  if (!(total > 0)) return residuals.length;
  let time = -1;
  for (let lag = 0; lag < Math.max(...lengths); lag += 2) {
    const pair = (sumProducts(residuals, lengths, lag) + sumProducts(residuals, lengths, lag + 1)) / total;
    if (pair <= 0) break;
    time += 2 * pair;
  }
  return Math.min(residuals.length / Math.max(time, 1), residuals.length);
}

function sumProducts(residuals: Float64Array, lengths: number[], lag: number): number {
  let sum = 0;
  let at = 0;
  for (const length of lengths) {
    for (let k = at; k + lag < at + length; k++) sum += residuals[k]! * residuals[k + lag]!;
    at += length;
  }
  return sum;
}

const NORMAL = 1.959963984540054;

/** Quantile of Student's t at 97.5 %: exact for 1 and 2 degrees of freedom, else an expansion in their inverse. */
export function findStudent(freedom: number): number {
  if (freedom <= 1) return 12.706204736432095;
  if (freedom === 2) return 4.302652729911275;
  if (freedom === 3) return 3.182446305284263;
  const z = NORMAL;
  const n = freedom;
  const terms = [
    (z ** 3 + z) / 4,
    (5 * z ** 5 + 16 * z ** 3 + 3 * z) / 96,
    (3 * z ** 7 + 19 * z ** 5 + 17 * z ** 3 - 15 * z) / 384,
    (79 * z ** 9 + 776 * z ** 7 + 1482 * z ** 5 - 1920 * z ** 3 - 945 * z) / 92160,
  ];
  return terms.reduce((sum, term, k) => sum + term / n ** (k + 1), z);
}
