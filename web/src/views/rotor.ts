// Numbers of a motor with an unbalance: its speed, the resonance of the beam, and where the motor jumps past it.

import { CAPTURED, WINDOW } from "../engine/constants.ts";
import type { Run } from "../lib/types.ts";
import { Computed, type Values } from "./formulas.ts";
import type { Measure } from "./results.ts";
import type { Views } from "./types.ts";

const RPM = { display_unit: "rpm", factor: 30 / Math.PI, offset: 0 };

export function findResonance(values: Values, { motor }: Pick<Views, "motor">): number | null {
  return motor.resonance === null ? null : new Computed(motor, values).one(motor.resonance);
}

/** Means of columns in windows of equal length. */
function averageWindows(run: Run, names: string[]): number[][] {
  const count = Math.floor(run.times.at(-1)! / WINDOW);
  const sums = names.map(() => new Array<number>(count).fill(0));
  const rows = new Array<number>(count).fill(0);
  run.times.forEach((time, k) => {
    const at = Math.floor(time / WINDOW);
    if (at >= count) return;
    rows[at]! += 1;
    names.forEach((name, i) => (sums[i]![at]! += run.columns[name]![k]!));
  });
  return sums.map((own) => own.flatMap((sum, at) => (rows[at] ? [sum / rows[at]!] : [])));
}

/** Voltage of the last window in which the resonance holds the motor; null if the motor is never held or never free. */
export function findJump(run: Run): number | null {
  if (!run.resonance || !run.columns["motor"] || !run.columns["rotor_speed"]) return null;
  const [speed, voltage] = averageWindows(run, ["rotor_speed", "motor"]) as [number[], number[]];
  const limit = CAPTURED * run.resonance;
  const last = speed.reduce((found, one, k) => (one < limit ? k : found), -1);
  return last < 0 || last === speed.length - 1 ? null : voltage[last]!;
}

/** The numbers to take away of a beam with a motor. */
export function measureRotor(run: Run): Measure[] {
  if (!run.resonance) return [];
  const how = run.outputs["displacement"]!;
  const volt = run.outputs["motor"] ?? { display_unit: "V", factor: 1, offset: 0 };
  const [low, high] = run.ends["displacement"] ?? [0, 0];
  return [
    { key: "amplitude", name: "Peak amplitude", value: Math.max(-low, high), how: { display_unit: how.display_unit, factor: how.factor, offset: 0 }, about: "Largest displacement of the tip", better: -1 },
    { key: "resonance", name: "Resonance", value: run.resonance, how: RPM, about: "√(k/M) of the beam: the speed at which the unbalance shakes it most", better: 0 },
    { key: "speed", name: "Top speed", value: run.ends["rotor_speed"]?.[1] ?? null, how: RPM, about: "Highest speed of the rotor", better: 0 },
    { key: "jump", name: "Jump at", value: findJump(run), how: volt, about: `Voltage at which the motor jumps past the resonance (mean speed over ${WINDOW} s above ${CAPTURED} times the resonance)`, better: 0 },
  ];
}
