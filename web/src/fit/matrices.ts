// Small symmetric matrices, row by row.

export type Matrix = number[][];

const SWEEPS = 60;

/** Eigenvalues, the largest first, and their unit vectors, by Jacobi's rotations. */
export function decomposeSymmetric(matrix: Matrix): { values: number[]; vectors: Matrix } {
  const size = matrix.length;
  const a = matrix.map((row) => [...row]);
  const v: Matrix = a.map((_, i) => a.map((__, j) => Number(i === j)));
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    let off = 0;
    for (let p = 0; p < size; p++) for (let q = p + 1; q < size; q++) off += rotateAway(a, v, p, q);
    if (off === 0) break;
  }
  const order = a.map((_, k) => k).sort((j, k) => a[k]![k]! - a[j]![j]!);
  return { values: order.map((k) => a[k]![k]!), vectors: order.map((k) => v.map((row) => row[k]!)) };
}

/** Turn away an element; whether there was something to turn. */
function rotateAway(a: Matrix, v: Matrix, p: number, q: number): number {
  const away = a[p]![q]!;
  if (Math.abs(away) <= 1e-17 * Math.sqrt(Math.abs(a[p]![p]! * a[q]![q]!)) || away === 0) return 0;
  const theta = (a[q]![q]! - a[p]![p]!) / (2 * away);
  const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
  const c = 1 / Math.hypot(t, 1);
  const s = t * c;
  for (const row of a) [row[p], row[q]] = [c * row[p]! - s * row[q]!, s * row[p]! + c * row[q]!];
  const [one, other] = [a[p]!, a[q]!];
  for (let k = 0; k < a.length; k++) [one[k], other[k]] = [c * one[k]! - s * other[k]!, s * one[k]! + c * other[k]!];
  for (const row of v) [row[p], row[q]] = [c * row[p]! - s * row[q]!, s * row[p]! + c * row[q]!];
  return 1;
}

export const dot = (one: ArrayLike<number>, other: ArrayLike<number>): number => {
  let sum = 0;
  for (let k = 0; k < one.length; k++) sum += one[k]! * other[k]!;
  return sum;
};

/** JᵀJ of columns. */
export const multiplyColumns = (columns: Float64Array[]): Matrix => columns.map((one) => columns.map((other) => dot(one, other)));

/** Root mean square. */
export const rms = (values: ArrayLike<number>): number => Math.sqrt(dot(values, values) / Math.max(1, values.length));
