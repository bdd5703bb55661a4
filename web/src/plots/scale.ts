// A scale of a chart: its ends, its ticks, and where a number lies on it.

export type Numbers = ArrayLike<number>;

export interface Scale {
  label: string;
  low: number;
  high: number;
  log?: boolean;
}

/** Share of the way from low to high. */
export function share({ low, high, log }: Scale, value: number): number {
  if (high === low) return 0.5;
  if (log) return Math.log(value / low) / Math.log(high / low);
  return (value - low) / (high - low);
}

/** The number at a share of the way. */
export const valueAt = ({ low, high, log }: Scale, part: number): number =>
  log ? low * (high / low) ** part : low + part * (high - low);

/** A scale around all values, wide enough for a constant to look like one. */
export function around(label: string, columns: Numbers[], room = 0.07, includes: readonly number[] = [], log = false): Scale {
  let [low, high] = [Infinity, -Infinity];
  for (const column of [...columns, includes]) {
    for (let i = 0; i < column.length; i++) {
      const value = column[i] as number;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low <= high)) return { label, low: 0, high: 1 };
  if (log && low > 0) {
    const wide = high > low ? (high / low) ** room : 1.5;
    return { label, low: low / wide, high: high * wide, log };
  }
  const size = Math.max(Math.abs(low), Math.abs(high));
  const wide = high - low;
  const extra = wide <= 1e-6 * size || wide === 0 ? 0.1 * size || 1 : room * wide;
  return { label, low: low - extra, high: high + extra };
}

/** The part of a scale between two of its shares. */
export const between = (scale: Scale, a: number, b: number): Scale => ({
  ...scale, low: valueAt(scale, Math.min(a, b)), high: valueAt(scale, Math.max(a, b)),
});

/** So much of a scale may a chart show at least, and how much more than all is all. */
const [LEAST, ALL] = [1e-5, 0.999];

/** A scale that shows `factor` times as much, the number at a share standing still; null once it would be all of `whole`. */
export function magnify(whole: Scale, now: Scale, at: number, factor: number): Scale | null {
  const wider = between(now, at - at * factor, at + (1 - at) * factor);
  const [a, b] = [share(whole, wider.low), share(whole, wider.high)];
  if (b - a >= ALL) return null;
  if (b - a < LEAST) return now;
  const shift = Math.max(0, -a) - Math.max(0, b - 1);
  return between(whole, a + shift, b + shift);
}

const stepOf = ({ low, high }: Scale, count: number): number => {
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((digit) => digit * power).find((one) => one >= rough * (1 - 1e-9)) ?? rough;
};

/** Round numbers between the ends, at most about so many. */
export function ticks(scale: Scale, count: number): number[] {
  const { low, high, log } = scale;
  const found: number[] = [];
  if (log && high / low > 3) {
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) {
      for (const digit of high / low > 100 ? [1] : [1, 2, 5]) found.push(digit * 10 ** power);
    }
    return found.filter((tick) => tick >= low && tick <= high);
  }
  const step = stepOf(scale, count);
  if (!(step > 0)) return found;
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}

/** A number at a tick; with as many digits as tell ticks so far apart from each other. */
export function tickText(value: number, step = 0): string {
  const size = Math.abs(value);
  const needed = step > 0 && size > 0 ? Math.min(Math.ceil(Math.log10(size / step) - 1e-9) + 1, 12) : 2;
  if (size === 0 || (size >= 1e-3 && size < 1e5)) return String(Number(value.toPrecision(Math.max(5, needed))));
  return value.toExponential(Math.max(1, needed - 1)).replace(/\.?0*e\+?/, "e");
}
