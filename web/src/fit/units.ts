// Units in which logs are written, and how quantities are shown.

import type { Shown } from "../identify/types.ts";

/** Unit -> SI unit, size and zero: SI = number * size + zero. */
const UNITS: Record<string, [si: string, size: number, zero?: number]> = {
  s: ["s", 1], ms: ["s", 1e-3], us: ["s", 1e-6], min: ["s", 60], hour: ["s", 3600],
  K: ["K", 1], degC: ["K", 1, 273.15], degF: ["K", 5 / 9, (459.67 * 5) / 9],
  N: ["N", 1], mN: ["N", 1e-3], kN: ["N", 1e3], gf: ["N", 9.80665e-3], kgf: ["N", 9.80665], lbf: ["N", 4.4482216152605], ozf: ["N", 0.27801385095378125],
  Pa: ["Pa", 1], kPa: ["Pa", 1e3], MPa: ["Pa", 1e6], GPa: ["Pa", 1e9], psi: ["Pa", 6894.757293168361], ksi: ["Pa", 6894757.293168361], bar: ["Pa", 1e5],
  "1": ["1", 1], "%": ["1", 1e-2], ppm: ["1", 1e-6],
  m: ["m", 1], mm: ["m", 1e-3], cm: ["m", 1e-2], um: ["m", 1e-6], in: ["m", 25.4e-3], thou: ["m", 25.4e-6],
  ohm: ["ohm", 1], mohm: ["ohm", 1e-3], kohm: ["ohm", 1e3],
  A: ["A", 1], mA: ["A", 1e-3], uA: ["A", 1e-6], V: ["V", 1], mV: ["V", 1e-3], W: ["W", 1], mW: ["W", 1e-3],
  rad: ["rad", 1], deg: ["rad", Math.PI / 180], "rad/s": ["rad/s", 1], rpm: ["rad/s", Math.PI / 30], "m/s": ["m/s", 1],
};

/** As others write them. */
const SPELLINGS: Record<string, string[]> = {
  degC: ["°C", "ºC", "C", "deg C", "degrees c", "celsius", "℃"], degF: ["°F", "ºF", "F", "deg F", "fahrenheit"], K: ["kelvin"],
  s: ["sec", "sec.", "secs", "second", "seconds", "sekunden"], ms: ["msec", "millisecond", "milliseconds"], us: ["µs", "μs"],
  min: ["minute", "minutes"], hour: ["h", "hr", "hours"], N: ["newton"], gf: ["g", "gm", "gram", "grams"], kgf: ["kg", "kp"], lbf: ["lb", "lbs"], ozf: ["oz"],
  MPa: ["N/mm^2", "N/mm²", "N/mm2"], "%": ["percent", "pct"], "1": ["-", "mm/mm", "m/m", "in/in"], ppm: ["microstrain", "ustrain", "µstrain", "μstrain", "µε", "με", "ue"],
  m: ["meter", "metre"], um: ["µm", "μm", "micron", "microns"], in: ["in.", "inch", "inches"], thou: ["mil", "mils"],
  ohm: ["ohms", "Ω", "Ω"], mohm: ["mΩ", "mΩ"], kohm: ["kOhm", "kΩ", "kΩ"], A: ["amp", "amps", "ampere"], uA: ["µA", "μA"], V: ["volt", "volts", "VDC"], W: ["watt", "watts"],
  deg: ["°"], rpm: ["1/min"],
};

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
  const [, size, zero = 0] = UNITS[unit]!;
  return values.map((x) => x * size + zero);
}

/** Units that a quantity in SI may be written in, the usual one first. */
export function listUnits(si: string, first = ""): string[] {
  const wanted = si ? [si] : ["V", "A", "W", "K"];
  return Object.keys(UNITS).filter((unit) => wanted.includes(siOf(unit))).sort((a, b) => Number(b === first) - Number(a === first));
}

const SHOWN: Record<string, string> = { K: "degC", m: "mm", Pa: "MPa", rad: "deg" };

/** How a column is shown. */
export function describeShown(name: string, si: string): Shown {
  const percent = si === "1" && /(^|\.)strain$/.test(name);
  const unit = percent ? "%" : (SHOWN[si] ?? si);
  const [, size, zero = 0] = UNITS[unit] ?? ["", 1];
  return { unit: si, shown: unit === "1" ? "" : unit, factor: 1 / size, offset: -zero / size };
}

/** How a difference of it is shown. */
export function describeDifference(name: string, si: string): Shown {
  const how = describeShown(name, si);
  return { ...how, shown: how.shown === "degC" ? "K" : how.shown, offset: 0 };
}
