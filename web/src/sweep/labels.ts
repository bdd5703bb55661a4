// What parameters are called: as on the bench, with their part where two would have one name.

import { capital } from "../lib/words.ts";
import type { Target } from "./types.ts";

/** What the bench calls a drive, by the last letter of its unit. */
const HEATING: Record<string, string> = { W: "Heating power", A: "Heating current", V: "Heating voltage" };
const DRIVE = /^drives?\..*(high|values?|amplitude)$/;
const SURROUNDINGS = "environment.temperature";

const words = (name: string): string => name.replaceAll("_", " ");
/** Symbols keep their letters: `A_s`, `E_M`, `h`. */
const isSymbol = (name: string): boolean => name.length === 1 || /^[A-Za-z]+_[A-Za-z]{1,2}$/.test(name);

function shortLabel({ name, unit }: Target): string {
  if (name === SURROUNDINGS) return "Ambient temperature";
  const heat = DRIVE.test(name) ? HEATING[unit.at(-1) ?? ""] : undefined;
  const last = name.split(".").at(-1) ?? name;
  return heat ?? (isSymbol(last) ? last : capital(words(last)));
}

/** Return the label of each parameter, by its path. */
export function labelsOf(targets: Target[]): Map<string, string> {
  const short = targets.map(shortLabel);
  return new Map(
    targets.map((one, k) => {
      const isShared = short.indexOf(short[k]!) !== short.lastIndexOf(short[k]!);
      const part = one.name.split(".").at(-2) ?? "";
      return [one.name, isShared && part ? `${short[k]} (${words(part)})` : short[k]!];
    }),
  );
}
