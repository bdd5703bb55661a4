// Alarms of a run, judged as martensite.simulate.alarms does, with the spans and panels of the page.

import { CYCLE, DRIFT, LOADED_ALIKE, RETURNED, ROUNDING } from "../engine/constants.ts";
import {
  writeDriftAlarm, writeExcursion, writeLimitAlarm, writeSlackAlarm, writeSourceAlarm, writeStrainAlarm, writeSupervisor, writeSupplyAlarm,
} from "../engine/sentences.ts";
import type { Alarm, Output } from "../lib/types.ts";
import { farthestChanges, findExcursion, findSpans, limitSpans, type Excursion, type Numbers, type Span } from "./excursions.ts";
import { Computed, fillRow, formatGeneral, type Columns, type Values } from "./formulas.ts";
import type { PortRows, Views } from "./types.ts";

/** Output of an actuator -> the one in whose panel it stands. */
export const TOGETHER: Record<string, string> = { hottest: "temperature", oriented_fraction: "martensite_fraction", heat_loss: "power" };

type Found = Omit<Alarm, "column" | "panel" | "how" | "spans" | "level" | "port">;
interface Judged {
  alarm: Found;
  column: string;
  margins: Numbers;
  level: number | null;
}

export interface Run {
  times: Numbers;
  columns: Columns;
  outputs: Record<string, Output>;
  parameters: Values;
  views: Views;
}

/** All alarms, by port, then that of a shared supply, then those of the supervisor. */
export function listAlarms(run: Run, warnings: (alarms: Alarm[]) => string[]): { alarms: Alarm[]; warnings: string[] } {
  const { elements } = run.views;
  const rows = Array.from(run.times, (_, k) => k);
  const known = new Computed(elements, run.parameters, run.columns, rows);
  const found: Alarm[] = [];
  for (const [port, at] of Object.entries(elements.ports))
    for (const one of judgePort(run, port, at, known)) found.push(place(run, one, elements.prefixed ? port : ""));
  if (elements.supply !== null) {
    const one = watchSupply(run, known.one(elements.supply));
    if (one) found.push(place(run, one, ""));
  }
  const told = warnings(found);
  return { alarms: [...found, ...listSupervised(run, told)], warnings: told };
}

function place(run: Run, { alarm, column, margins, level }: Judged, port: string): Alarm {
  return {
    ...alarm,
    port,
    sentence: port ? alarm.sentence.replace("Warning: ", `Warning: \`${port}\`: `) : alarm.sentence,
    column,
    how: run.outputs[column]!,
    panel: TOGETHER[alarm.quantity] ?? alarm.quantity,
    spans: findSpans(run.times, margins),
    level,
  };
}

function judgePort(run: Run, port: string, at: PortRows, known: Computed): Judged[] {
  const name = (output: string): string => (run.views.elements.prefixed ? `${port}.${output}` : output);
  const column = (output: string): Numbers => run.columns[name(output)]!;
  const found = [
    watchAbove(run.times, column("hottest"), name("hottest"), "temperature", known.one(at.temperature), [273.15, "°C", 1]),
    watchAbove(run.times, column("stress"), name("stress"), "stress", known.one(at.stress), [0, "MPa", 1e6]),
    watchStrain(run.times, column("strain"), name("strain"), known.one(at.strain)),
    watchSlack(run.times, column("force"), name("force")),
    watchSource(run.times, column("drive"), name("drive"), at, known),
    watchFirstCycle(run, name, run.views.elements.alone),
  ];
  return found.filter((one) => one !== null);
}

const words = (when: Excursion): string => writeExcursion(when.first, when.duration);
const differences = (values: Numbers, limit: number): Float64Array => fillRow(values.length, (k) => values[k]! - limit);

function make(times: Numbers, when: Excursion, kind: string, quantity: string, unit: string, worst: number, limit: number, sentence: string): Found {
  return {
    kind, quantity, unit, worst, limit, sentence, excess: Math.abs(worst - limit), first: when.first, duration: when.duration,
    worst_time: times[when.worst]!,
  };
}

function watchAbove(times: Numbers, values: Numbers, column: string, kind: "temperature" | "stress", limit: number, [zero, shown, scale]: [number, string, number]): Judged | null {
  const margins = differences(values, limit);
  const when = findExcursion(times, margins);
  if (!when) return null;
  const worst = values[when.worst]!;
  const sentence = writeLimitAlarm(kind, worst, zero, scale, shown, limit, words(when));
  const [quantity, unit] = kind === "stress" ? ["stress", "Pa"] : ["hottest", "K"];
  return { alarm: make(times, when, kind, quantity!, unit!, worst, limit, sentence), column, margins, level: limit };
}

function watchStrain(times: Numbers, strain: Numbers, column: string, limit: number): Judged | null {
  const changes = farthestChanges(strain);
  const margins = differences(changes, limit);
  const when = findExcursion(times, margins);
  if (!when) return null;
  const worst = changes[when.worst]!;
  const sentence = writeStrainAlarm(worst, limit, words(when));
  return { alarm: make(times, when, "strain", "strain", "1", worst, limit, sentence), column, margins, level: null };
}

/** No force, after there was some. */
function watchSlack(times: Numbers, force: Numbers, column: string): Judged | null {
  const slack = Array.from(force, (value) => value <= 0);
  const worst = slack.indexOf(true);
  if (worst < 0 || !(force[0]! > 0)) return null;
  let duration = 0;
  for (let k = 1; k < slack.length; k++) if (slack[k - 1] && slack[k]) duration += times[k]! - times[k - 1]!;
  const when = { first: times[worst]!, duration, worst };
  const alarm = { ...make(times, when, "slack", "force", "N", force[worst]!, 0, writeSlackAlarm(words(when))), excess: 0 };
  return { alarm, column, margins: slack.map((one) => (one ? 1 : -1)), level: null };
}

/** A source that is asked for what it cannot deliver. */
function watchSource(times: Numbers, drive: Numbers, column: string, at: PortRows, known: Computed): Judged | null {
  const [least, most] = at.reach;
  const margins = fillRow(drive.length, (k) => Math.max(drive[k]! - known.at(most, k), known.at(least, k) - drive[k]!) - ROUNDING * Math.abs(drive[k]!));
  const when = findExcursion(times, margins);
  if (!when) return null;
  const worst = drive[when.worst]!;
  const limit = Math.min(Math.max(worst, known.at(least, when.worst)), known.at(most, when.worst));
  const sentence = writeSourceAlarm(at.source, times[when.worst]!, limit, at.unit, worst, words(when));
  return { alarm: make(times, when, "supply", "drive", at.unit, worst, limit, sentence), column, margins, level: null };
}

function watchSupply(run: Run, limit: number): Judged | null {
  const demand = run.columns["supply_demand"]!;
  const when = findExcursion(run.times, differences(demand, limit * (1 + ROUNDING)));
  if (!when) return null;
  const worst = demand[when.worst]!;
  const sentence = writeSupplyAlarm(worst, run.times[when.worst]!, limit, run.columns["supply_voltage"]![when.worst]!, words(when));
  const alarm = make(run.times, when, "rig", "supply_demand", "A", worst, limit, sentence);
  return { alarm, column: "supply_demand", margins: differences(demand, limit), level: null };
}

/** Another orientation after the first cycle than at the start. */
function watchFirstCycle(run: Run, name: (output: string) => string, alone: boolean): Judged | null {
  const { times, columns } = run;
  const [fraction, oriented, stress, strain] = ["martensite_fraction", "oriented_fraction", "stress", "strain"].map((one) => columns[name(one)]!) as [Numbers, Numbers, Numbers, Numbers];
  const at = findReturn(fraction, stress, alone);
  if (at === null) return null;
  const [start, share] = [oriented[0]! / fraction[0]!, oriented[at]! / fraction[at]!];
  if (Math.abs(share - start) <= DRIFT) return null;
  const percent = (value: number): string => `${formatGeneral(100 * value, 3)} %`;
  const sentence = writeDriftAlarm(start, percent(strain[0]!), share, times[at]!, percent(strain[at]!));
  const when = { first: times[at]!, duration: times[times.length - 1]! - times[at]!, worst: at };
  const alarm = make(times, when, "drift", "oriented_fraction", "1", share, start, sentence);
  return { alarm, column: name("oriented_fraction"), margins: differences(oriented, start), level: null };
}

/** Where after a first cycle the stress is most like that of the start; null if it is not. */
function findReturn(fraction: Numbers, stress: Numbers, alone: boolean): number | null {
  const [full, hot, count] = [fraction[0]! - RETURNED, fraction[0]! - CYCLE, fraction.length];
  const next = (from: number, holds: (value: number) => boolean): number => {
    let k = from;
    while (k < count && !holds(fraction[k]!)) k++;
    return k;
  };
  const back = next(next(0, (value) => value < hot), (value) => value >= full);
  if (back >= count || hot < 0) return null;
  const end = next(back, (value) => value < full);
  let found = back;
  const off = (k: number): number => Math.abs(stress[k]! - stress[0]!);
  for (let k = back; k < end; k++) if (off(k) < off(found)) found = k;
  const alike = off(found) <= LOADED_ALIKE * Math.max(Math.abs(stress[found]!), Math.abs(stress[0]!));
  return alone || alike ? found : null;
}

/** What the supervisor of a loop raised. */
function listSupervised(run: Run, warnings: string[]): Alarm[] {
  const { guard } = run.views;
  const raised = guard && run.columns[guard.column];
  if (!raised) return [];
  const spans: Span[] = [];
  let begin: number | null = null;
  for (let k = 0; k < raised.length; k++) {
    const on = raised[k]! > 0.5;
    if (on && begin === null) begin = run.times[k]!;
    if (!on && begin !== null) {
      spans.push([begin, run.times[k]!]);
      begin = null;
    }
  }
  if (begin !== null) spans.push([begin, run.times[run.times.length - 1]!]);
  if (!spans.length) return [];
  const first = spans[0]![0];
  const duration = spans.reduce((sum, [from, to]) => sum + (to - from), 0);
  return [
    {
      kind: "supervisor", quantity: guard.column, unit: "1", worst: 1, limit: 0, excess: 1, first, duration, worst_time: first, port: "",
      sentence: warnings.find((one) => one.startsWith("Warning: The guard")) ?? writeSupervisor(first, duration),
      column: guard.column, panel: guard.column, how: run.outputs[guard.column]!, spans: limitSpans(spans), level: null,
    },
  ];
}
