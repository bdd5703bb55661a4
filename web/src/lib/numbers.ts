// Numbers for people.

/** A number with so many significant digits, without a tail of zeros. */
export function digits(value: number | null | undefined, count = 4): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(count - 1).replace(/\.?0+e/, "e");
  return String(Number(value.toPrecision(count)));
}

/** SI to what is shown. */
export const toShown = (value: number, how: { factor: number; offset: number }): number => value * how.factor + how.offset;

/** A difference in SI to what is shown. */
export const difference = (value: number, how: { factor: number }): number => value * how.factor;

/**
 * A number as people type it, with a decimal point: `0,2 mm` is 0.2 mm, also in full-width digits.
 *
 * A comma before exactly three digits, and more than one, may stand between thousands: such a text stays as it is, and is refused
 * with a sentence.
 */
export const readComma = (typed: string): string => {
  const text = typed.normalize("NFKC");
  return /^\s*[+-]?[1-9]\d{0,2}(,\d{3})+(?!\d)/.test(text) ? text : text.replace(/^(\s*[+-]?\d*),(\d+)(?![\d,.]*[,.])/, "$1.$2");
};
