// The numbers of a picture, for a spreadsheet.

import type { Numbers, Picture } from "./picture.ts";

const quote = (cell: string): string => (/[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);

/** Columns of numbers beside each other; shorter ones end in empty cells. */
function writeColumns(columns: [name: string, values: Numbers | string[]][]): string {
  const length = Math.max(...columns.map(([, values]) => values.length));
  const rows = Array.from({ length }, (_, k) =>
    columns.map(([, values]) => {
      const value = values[k] ?? "";
      return typeof value === "number" && !Number.isFinite(value) ? "" : quote(String(value));
    }),
  );
  return [columns.map(([name]) => quote(name)), ...rows].map((row) => row.join(",")).join("\n") + "\n";
}

/** The numbers of a picture, for a spreadsheet: a curve over the same numbers as the one before shares their column. */
export function writeNumbers({ x, y, colour, curves, spots = [] }: Picture): string {
  if (spots.length) {
    return writeColumns([
      [x.label, spots.map((spot) => spot.x)],
      [y.label, spots.map((spot) => (spot.state === "failed" && !colour ? NaN : spot.y))],
      ...(colour ? [[colour.label, spots.map((spot) => spot.value ?? NaN)] as [string, number[]]] : []),
      ["state", spots.map((spot) => spot.state)],
    ]);
  }
  const columns: [string, Numbers][] = [];
  let last: Numbers | null = null;
  for (const curve of curves) {
    const [first, end] = curve.part ?? [0, curve.x.length - 1];
    const cut = (values: Numbers): Numbers => (curve.part ? Array.from(values).slice(first, end + 1) : values);
    if (curve.x !== last || curve.part) columns.push([x.label, cut(curve.x)]);
    columns.push([curve.name ? `${curve.name}, ${y.label}` : y.label, cut(curve.y)]);
    last = curve.x;
  }
  return columns.length ? writeColumns(columns) : "";
}
