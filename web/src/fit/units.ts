// Units in which logs are written, and how quantities are shown.

import type { Shown } from "../identify/types.ts";
import vocabulary from "./vocabulary.json" with { type: "json" };

/** Unit -> SI unit, size and zero: SI = number * size + zero. */
const UNITS = vocabulary.units as unknown as Record<string, [si: string, size: number, zero: number]>;
/** Unit of a drive, whatever it is. */
export const DRIVE = "drive";
/** As others write them. */
const SPELLINGS: Record<string, string[]> = vocabulary.spellings;
/** Units of what may drive. */
export const DRIVEN_BY: string[] = vocabulary.driven_by;

/** A unit as it is written here; empty for what is none. */
export function findUnit(spelling: string): string {
  const plain = spelling.trim();
  if (plain in UNITS) return plain;
  for (const [unit, others] of Object.entries(SPELLINGS)) {
    if (others.includes(plain) || (plain.length > 2 && others.includes(plain.toLowerCase()))) return unit;
  }
  return "";
}

export const siOf = (unit: string): string => UNITS[unit]?.[0] ?? "";

/** Numbers in SI. */
export function toSi(values: Float64Array, unit: string): Float64Array {
  const [, size, zero] = UNITS[unit]!;
  return values.map((x) => x * size + zero);
}

/** Units that a quantity in SI may be written in, the usual one first. */
export function listUnits(si: string, first = ""): string[] {
  const wanted = si === DRIVE ? DRIVEN_BY : [si];
  return Object.keys(UNITS).filter((unit) => wanted.includes(siOf(unit))).sort((a, b) => Number(b === first) - Number(a === first));
}

/** The unit in which a person would rather read one in SI. */
export const READABLE: Record<string, string> = vocabulary.readable;

/** How a column is shown. */
export function describeShown(name: string, si: string): Shown {
  const percent = si === "1" && /(^|\.)strain$/.test(name);
  const unit = percent ? "%" : (READABLE[si] ?? si);
  const [, size, zero] = UNITS[unit] ?? ["", 1, 0];
  return { unit: si, shown: unit === "1" ? "" : unit, factor: 1 / size, offset: -zero / size };
}

/** How a difference of it is shown. */
export function describeDifference(name: string, si: string): Shown {
  const how = describeShown(name, si);
  return { ...how, shown: how.shown === "degC" ? "K" : how.shown, offset: 0 };
}
