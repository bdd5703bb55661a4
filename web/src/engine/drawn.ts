// What the page draws of a run: its columns, thinned out, and what the manifest knows of them.

import type { Run } from "../lib/types.ts";
import type { RunCore, Scenario } from "./types.ts";

/** Points that are drawn of a column; more cannot be told apart on a screen. */
const MOST_ROWS = 2001;

/** Rows, at most so many, first and last among them. */
export function chooseRows(count: number, most = MOST_ROWS): number[] {
  if (count <= most) return Array.from({ length: count }, (_, k) => k);
  return Array.from({ length: most }, (_, k) => Math.round((k * (count - 1)) / (most - 1)));
}

export function drawRun(scenario: Scenario, core: RunCore): Run {
  const rows = chooseRows(core.times.length);
  const pick = (values: Float64Array): number[] => rows.map((k) => values[k]!);
  const stroke = core.columns[scenario.coordinate] ?? new Float64Array([0]);
  return {
    text: core.text,
    title: scenario.title,
    described: scenario.described,
    status: core.status,
    accuracy: core.accuracy,
    steps: core.steps,
    step: core.step,
    stroke: stroke.reduce((a, b) => Math.max(a, b)) - stroke.reduce((a, b) => Math.min(a, b)),
    coordinate: scenario.coordinate,
    ports: scenario.ports,
    cautions: core.cautions,
    warnings: core.warnings,
    alarms: [],
    runtime: "WebAssembly",
    seconds: core.seconds,
    times: pick(core.times),
    columns: Object.fromEntries(Object.entries(core.columns).map(([name, values]) => [name, pick(values)])),
    outputs: scenario.outputs,
    traces: scenario.traces,
    loops: scenario.loops,
    stretches: {},
    phase: { diagrams: [], ports: {} },
    energy: { courses: [], efficiency: null, sentence: "" },
    key: [],
    scene: { shapes: [], times: [], quantum: 1, frames: [], turns: [], low: [0, 0, 0], high: [0, 0, 0], ports: {} },
  };
}
