// What a report of a run holds: less than the bench draws, in fewer digits.

import type { GroupNode } from "../form/types.ts";
import { packed } from "../lib/pack.ts";
import type { Run } from "../lib/types.ts";

export interface ReportData {
  run: Run;
  pins: { id: number; name: string; run: Run }[];
  notes: string;
  /** What limits the run, and what a run of its own promised; empty if nothing is to be said. */
  insight: string;
  /** Which program made it, and when. */
  made: string;
  /** Entries of the documents that differ: path, and value by run. */
  differences: { path: string; values: (string | null)[] }[];
  /** The form of the scenario: its numbers and where they are from. */
  sections: GroupNode[];
  parts: Record<string, unknown>;
}

/** Where the data stand in the bundled page. */
export const PLACE = '<script type="text/plain" id="report-data">';
/** The largest report [bytes], and rows of a run that are tried for it, one after the other. */
const LARGEST = 290_000;
const ROWS = [1500, 750, 375, 190];
const DIGITS = 5;

/** Names of the columns that are drawn. */
function drawn(run: Run): Set<string> {
  const traces = run.traces.flatMap((panel) => Object.values(panel.ports).flat());
  const loops = run.loops.flatMap((loop) => Object.values(loop.ports).flat());
  const paths = Object.values(run.phase.ports).flatMap(({ x, y }) => [x, y]);
  return new Set([...traces, ...loops, ...paths, ...run.alarms.map((alarm) => alarm.column)]);
}

/** A run with what its charts need: no motion, at most so many rows. */
function shorten(run: Run, most: number): Run {
  const names = drawn(run);
  const stride = Math.max(1, Math.ceil(run.times.length / most));
  const last = run.times.length - 1;
  const thin = <T>(values: T[]): T[] => values.filter((_, k) => k % stride === 0 || k === last);
  const place = (row: number): number => (row === last ? Math.ceil(last / stride) : Math.round(row / stride));
  const only = <T>(table: Record<string, T>): [string, T][] => Object.entries(table).filter(([name]) => names.has(name));
  return {
    ...run,
    times: thin(run.times),
    columns: Object.fromEntries(only(run.columns).map(([name, values]) => [name, thin(values)])),
    outputs: Object.fromEntries(only(run.outputs)),
    stretches: Object.fromEntries(
      Object.entries(run.stretches).map(([port, parts]) => [port, parts.map(([sense, first, end]) => [sense, place(first), place(end)])]),
    ),
    energy: {
      ...run.energy,
      courses: run.energy.courses.map((course) => ({ ...course, values: thin(course.values) })),
      efficiency: run.energy.efficiency && thin(run.energy.efficiency),
    },
    scene: { shapes: [], times: [], quantum: 1, frames: [], turns: [], low: [0, 0, 0], high: [0, 0, 0], newton: 0, ports: {} },
  } as Run;
}

const rounded = (_: string, value: unknown): unknown => (typeof value === "number" ? Number(value.toPrecision(DIGITS)) : value);

/** The page of a report: the bundled one with the data put in; longer runs in fewer samples. */
export async function fillReport(page: string, data: ReportData): Promise<string> {
  const [before = "", after] = page.split(PLACE);
  if (after === undefined) throw new Error("The page of the report cannot be read.");
  const room = LARGEST - before.length - after.length;
  let letters = "";
  for (const most of ROWS) {
    const short = { ...data, run: shorten(data.run, most), pins: data.pins.map((pin) => ({ ...pin, run: shorten(pin.run, most) })) };
    letters = await packed(JSON.stringify(short, rounded), "deflate");
    if (letters.length < room) break;
  }
  return before + PLACE + letters + after;
}
