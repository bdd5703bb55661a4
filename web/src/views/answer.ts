// The run that the server tells, with what the page draws of it by itself.

import type { Run, RunAnswer } from "../lib/types.ts";
import { describePhase } from "./diagrams.ts";
import { drawScene } from "./drawing.ts";
import { findResonance } from "./rotor.ts";
import { listStretches } from "./columns.ts";
import type { Views } from "./types.ts";

export function completeRun({ parameters, views, ...told }: RunAnswer): Run {
  const drawn = views as Pick<Views, "lines" | "scene" | "motor">;
  const values = Object.fromEntries(Object.entries(parameters).map(([path, value]) => [path, Number(value)]));
  return {
    ...told,
    stretches: Object.fromEntries(drawn.lines.ports.map(({ port, x }) => [port, listStretches(told.columns[x]!)])),
    phase: describePhase(told.columns, values, drawn),
    scene: drawScene(told.times, told.columns, values, drawn),
    resonance: findResonance(values, drawn),
  };
}

/** Answers of the server as the page takes them. */
export const completeAnswer = (call: string, answer: unknown): unknown => (call === "run" ? completeRun(answer as RunAnswer) : answer);
