// A scale of a picture: its ends, its ticks, and where a number lies on it.

export interface Dim {
  label: string;
  low: number;
  high: number;
  log?: boolean;
}

/** Share of the way from low to high. */
export function share({ low, high, log }: Dim, value: number): number {
  if (high === low) return 0.5;
  if (log) return Math.log(value / low) / Math.log(high / low);
  return (value - low) / (high - low);
}

/** A scale around numbers, with a margin on both sides. */
export function around(label: string, values: Iterable<number>, margin = 0.04, log = false): Dim {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return { label, low: 0, high: 1 };
  if (log && low > 0) {
    const wide = (high / low) ** margin;
    return { label, low: low / wide, high: high * wide, log };
  }
  const apart = high - low || Math.abs(high) * 0.1 || 1;
  return { label, low: low - margin * apart, high: high + margin * apart };
}

export function ticks({ low, high, log }: Dim, count: number): number[] {
  if (log && high / low > 3) {
    const found: number[] = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) {
      for (const digit of high / low > 100 ? [1] : [1, 2, 5]) found.push(digit * 10 ** power);
    }
    return found.filter((tick) => tick >= low && tick <= high);
  }
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((digit) => digit * power).find((one) => one >= rough) ?? rough;
  const found: number[] = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}

export const tickText = (value: number): string => {
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(1).replace(".0e", "e") : String(Number(value.toPrecision(5)));
};
