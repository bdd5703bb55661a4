// What the heading of a column probably means: martensite/scenario/heading_guess.py for the page.

import { DRIVE, DRIVEN_BY, findUnit, listUnits, READABLE, siOf } from "./units.ts";
import vocabulary from "./vocabulary.json" with { type: "json" };

/** Known columns with their SI unit, and what else they are called. */
const QUANTITIES = vocabulary.quantities as unknown as Record<string, [si: string, words: string[]]>;
/** SI unit -> column that has it. */
const BY_UNIT: Record<string, string> = vocabulary.by_unit;
/** The unit in which a column is usually written. */
const findUsual = (name: string, si: string): string => (name === "strain" ? "%" : (READABLE[si] ?? si));
const IMPLIED: Record<string, string> = { millis: "ms", micros: "us", milliseconds: "ms", microseconds: "us", seconds: "s" };
const NUMBERED = ["channel", "ch", "kanal", "sensor", "probe", "input", "trace", "analog", "digital"];
const BRACKETS = /^(.*?)\s*[[(]\s*([^\])]*?)\s*[\])]\s*$/;
const APART = /^(.*\S)\s*\/\s*(\S.*)$|^(.*\S)\s+in\s+(\S+)$|^(.*\S)[\s_]+(\S+?)$/;

/** The part of a name behind its port. */
const cutPort = (name: string): string => name.split(".").at(-1) ?? name;
export const quantityOf = (name: string): string | undefined => QUANTITIES[cutPort(name)]?.[0];

/** Known names, each with the units it may be in. */
export const listNames = (): Record<string, string[]> =>
  Object.fromEntries(Object.entries(QUANTITIES).map(([name, [si]]) => [name, listUnits(si, si === DRIVE ? DRIVEN_BY[0] : findUsual(name, si))]));

/** Whether a unit suits a known column. */
function suitsUnit(name: string, unit: string): boolean {
  const si = quantityOf(name);
  return si === DRIVE ? DRIVEN_BY.includes(siOf(unit)) : siOf(unit) === si;
}

export interface Guess {
  name: string;
  unit: string;
}

/** Name and unit of a column, empty where nothing speaks for anything. */
export function guessHeading(heading: string, written = ""): Guess {
  const implied = IMPLIED[heading.trim().toLowerCase()];
  if (implied) return { name: "time", unit: implied };
  const [words, spelling] = partHeading(heading.trim());
  const unit = findUnit(written) || findUnit(spelling);
  const [, port = "", plain = words] = /^([A-Za-z_]\w*\.)(\w+)$/.exec(words) ?? [];
  const name = findNamed(plain, unit);
  return { name: name && `${port.toLowerCase()}${name}`, unit };
}

function partHeading(heading: string): [string, string] {
  const bracketed = BRACKETS.exec(heading);
  if (bracketed) return [bracketed[1]!, bracketed[2]!];
  const [words, last] = (APART.exec(heading)?.slice(1) ?? []).filter((part) => part !== undefined);
  if (words && last && findUnit(last) && !/^\d+$/.test(last) && !NUMBERED.includes(words.toLowerCase())) return [words, last];
  return heading.endsWith("%") ? [heading.slice(0, -1), "%"] : [heading, ""];
}

/** The known column that some words name, if its unit agrees; else the one of that unit. */
function findNamed(words: string, unit: string): string {
  const plain = words.trim().replace(/[\s-]+/g, "_");
  if (plain.toLowerCase() in QUANTITIES) return plain.toLowerCase();
  for (const part of [plain, ...plain.split(/[_:,.]+/)].map((one) => one.replace(/\d+$/, ""))) {
    const found = Object.entries(QUANTITIES).find(
      ([name, [, others]]) => name !== "drive" && (others.includes(part) || (part.length > 1 && [name, ...others].includes(part.toLowerCase()))) && (!unit || suitsUnit(name, unit)),
    );
    if (found) return found[0];
  }
  return unit ? (BY_UNIT[siOf(unit)] ?? "") : "";
}

/** The unit of a known quantity by the size of its numbers, where the heading names none; a guess. */
export function guessUnit(name: string, values: Float64Array): string {
  const size = values.reduce((most, x) => (Math.abs(x) > most ? Math.abs(x) : most), 0);
  const least = values.reduce((low, x) => (x < low ? x : low), Infinity);
  const own = cutPort(name);
  if (own === "temperature") return least > 200 ? "K" : "degC";
  if (own === "strain") return size <= 0.12 ? "1" : size <= 15 ? "%" : "ppm";
  if (own === "stress") return size > 1e5 ? "Pa" : "MPa";
  if (own === "martensite_fraction" || own === "duty") return size <= 1 ? "1" : "%";
  if (own === "voltage") return size <= 60 ? "V" : "mV";
  if (own === "current") return size <= 15 ? "A" : "mA";
  if (own === "angle" || own === "rotor_angle") return size > 6.3 ? "deg" : "rad";
  return own === "drive" || own === "rotor_speed" ? "" : findUsual(own, quantityOf(own) ?? "");
}
