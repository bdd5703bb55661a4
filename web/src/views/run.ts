// What the page draws of a run, made from its columns and from what martensite.app.views.page says of its scenario.

import { ENERGIES } from "../engine/constants.ts";
import type { RunCore, Scenario } from "../engine/types.ts";
import type { Alarm, KeyResult, Run } from "../lib/types.ts";
import { listAlarms } from "./alarms.ts";
import { chooseCurveRows, dropRepeated, endsOf, listStretches, mergeRows, pickRows } from "./columns.ts";
import { describePhase } from "./diagrams.ts";
import { drawScene } from "./drawing.ts";
import { describeEnergy, efficiencyAt, integrateEnergies, type Energies } from "./energies.ts";
import { formatGeneral, type Values } from "./formulas.ts";
import { findResonance } from "./rotor.ts";
import type { Views } from "./types.ts";
import { listWarnings } from "./warnings.ts";

/** What is smaller is the error of rounding. */
const NOTHING = 1e-12;

/** What of a scenario the views need. */
export type Described = Pick<Scenario, "title" | "described" | "outputs" | "coordinate" | "ports" | "traces" | "loops" | "views">;

/** The run as the server tells it (martensite.app.calls.scenarios). */
export function describeRun(core: RunCore, scenario: Described, values: Values = core.parameters): Run {
  const { views, outputs, ports } = scenario;
  const judged = core.track ?? core;
  const { times, columns } = mergeRows(core);
  const ends = endsOf(columns);
  const rows = chooseCurveRows(times.length, columns);
  const thinned = Object.fromEntries(Object.entries(columns).map(([name, column]) => [name, pickRows(column, rows)]));
  const { alarms, warnings } = listAlarms({ times: judged.times, columns: judged.columns, outputs, parameters: values, views }, (found) => listWarnings(core, views, values, found));
  const energies = integrateEnergies(core, { times, columns }, values, views);
  const temperature = (port: string): string => (views.elements.prefixed ? `${port}.temperature` : "temperature");
  return {
    text: core.text,
    title: scenario.title,
    described: scenario.described,
    status: core.status,
    accuracy: core.accuracy,
    samples: core.times.length,
    steps: core.steps,
    step: core.step,
    stroke: range(ends, scenario.coordinate),
    ends,
    coordinate: scenario.coordinate,
    ports,
    cautions: core.cautions,
    warnings,
    alarms,
    runtime: "WebAssembly",
    seconds: core.seconds,
    times: pickRows(times, rows),
    columns: thinned,
    outputs,
    traces: dropRepeated(scenario.traces, core.columns),
    loops: scenario.loops,
    stretches: Object.fromEntries(ports.map((port) => [port, listStretches(thinned[temperature(port)]!)])),
    phase: describePhase(columns, values, views),
    energy: describeEnergy(energies, rows),
    key: listKeyResults(ends, views, energies, alarms.filter((one) => one.kind !== "supervisor")),
    scene: drawScene(times, columns, values, views),
    resonance: findResonance(values, views),
  };
}

type Ends = Record<string, [low: number, high: number]>;

const range = (ends: Ends, name: string): number => ends[name]![1] - ends[name]![0];
const spell = (number: string, unit: string): string => (unit ? `${number} ${unit}` : number);

/** The few numbers by which runs are compared; see martensite.show.summaries.run. */
function listKeyResults(ends: Ends, { key }: Views, energies: Energies | string, alarms: Alarm[]): KeyResult[] {
  const strokes = key.strokes.map((one): KeyResult => [one.words, spell(formatGeneral(range(ends, one.column) / one.size, 4), one.unit)]);
  const peaks = key.peaks.map((one): KeyResult => {
    const own = one.columns.map((name) => ends[name]![one.least ? 0 : 1]);
    const value = one.least ? Math.min(...own) : Math.max(...own);
    return [one.words, spell(formatGeneral(((Math.abs(value) > NOTHING ? value : 0) - one.zero) / one.size, 4), one.unit)];
  });
  const beyond = alarms.reduce((sum, one) => sum + one.duration, 0);
  return [...strokes, ...peaks, ...listEnergies(energies), ["time beyond limits", `${formatGeneral(beyond, 4)} s`]];
}

function listEnergies(found: Energies | string): KeyResult[] {
  if (typeof found === "string") return [];
  const last = found.electrical.length - 1;
  const names = ["electrical", "lost", "work", "returned"] as const;
  const told = names.flatMap((name): KeyResult[] => {
    const [, words, unit, factor] = ENERGIES[name];
    const values = found[name];
    return values ? [[words, `${formatGeneral(factor * values[last]!, 4)} ${unit}`]] : [];
  });
  return found.work ? [...told, ["efficiency (work over electrical)", `${formatGeneral(100 * efficiencyAt(found, last), 4)} %`]] : told;
}
