// The phase diagram of a run: lines of the laws that follow from their numbers, up to its highest stress.

import { COLDER, HEADROOM, LEAST_STRESS, STRESSES, TEMPERATURES } from "../engine/constants.ts";
import type { Band, Line, Phase } from "../lib/types.ts";
import { highest as most, lowest } from "./columns.ts";
import { Computed, type Columns, type Values } from "./formulas.ts";
import type { LinesAt, Views } from "./types.ts";

const OTHER_NUMBERS =
  "This page cannot compute the phase diagram for these parameters of the law.";

interface Limits {
  stress: number;
  cold: number;
}

/** Actuators whose laws are alike in kind and numbers share a diagram. */
export function describePhase(columns: Columns, parameters: Values, { lines }: Pick<Views, "lines">): Phase {
  const known = new Computed(lines, parameters);
  const limits = findLimits(columns, lines.ports);
  const laws: string[] = [];
  const found: Phase = { diagrams: [], ports: {} };
  for (const at of lines.ports) {
    const numbers = Object.fromEntries(Object.entries(lines.numbers[at.port]!).map(([name, row]) => [name, known.one(row)]));
    const law = JSON.stringify([at.structure, Object.values(numbers).map(String)]);
    if (!laws.includes(law)) {
      laws.push(law);
      found.diagrams.push(drawDiagram(at, numbers, limits));
    }
    found.ports[at.port] = { diagram: laws.indexOf(law), x: at.x, y: at.y };
  }
  return found;
}

function findLimits(columns: Columns, ports: LinesAt[]): Limits {
  const stress = Math.max(...(ports.length ? ports.map(({ y }) => most(columns[y]!)) : [0]));
  const cold = Math.min(...(ports.length ? ports.map(({ x }) => lowest(columns[x]!)) : [300]));
  return {
    stress: STRESSES * Math.ceil(Math.max(LEAST_STRESS, HEADROOM * stress) / STRESSES),
    cold: TEMPERATURES * Math.floor((cold - 8) / TEMPERATURES),
  };
}

function drawDiagram({ kind, driven }: LinesAt, law: Values, { stress, cold }: Limits): Phase["diagrams"][number] {
  if (driven) {
    const same = Object.entries(driven.values).every(([name, value]) => Math.abs(law[name]! - Number(value)) <= 1e-12 * Math.abs(law[name]!) || String(value) === String(law[name]));
    return same ? { bands: driven.bands, highest: driven.highest, sentence: driven.sentence } : { bands: [], highest: stress, sentence: OTHER_NUMBERS };
  }
  const [M_s, M_f, C_M, C_A] = ["M_s", "M_f", "C_M", "C_A"].map((name) => law[name]!) as [number, number, number, number];
  const shifted = (name: string, slope: number): Line => ({ name, temperature: [law[name]!, law[name]! + stress / slope], stress: [0, stress] });
  const reverse: Band = { process: "reverse", start: shifted("A_s", C_A), finish: shifted("A_f", C_A) };
  if (kind === "strips") {
    const forward: Band = { process: "forward", start: shifted("M_s", C_M), finish: shifted("M_f", C_M) };
    return { bands: [forward, reverse], highest: stress, sentence: "" };
  }
  const top = Math.max(stress, law["sigma_f"]!);
  const coldest = Math.min(cold, M_f - COLDER);
  const loading = (name: string): Line => {
    const low = law[name]!;
    return { name, temperature: [coldest, M_s, M_s + (top - low) / C_M], stress: [low, low, top] };
  };
  const upright = (name: string, at: number, end: string): Line => ({ name, temperature: [at, at], stress: [0, law[end]!] });
  const bands: Band[] = [
    { process: "loading", start: loading("sigma_s"), finish: loading("sigma_f") },
    { process: "cooling", start: upright("M_s", M_s, "sigma_s"), finish: upright("M_f", M_f, "sigma_f") },
    reverse,
  ];
  return { bands, highest: stress, sentence: "" };
}
