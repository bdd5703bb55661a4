// The calls of Identify that a page without a server answers by itself; see martensite.app.calls.logs.

import { fetchFile } from "../engine/files.ts";
import { locateFile, readManifest } from "../engine/local.ts";
import type { OverlayView, RecordsView, ScenarioView, TableView } from "../identify/types.ts";
import type { Uploaded } from "../lib/api.ts";
import { Refusal } from "../lib/refusal.ts";
import { followDrive, matchOutputs, readFollowed } from "./following.ts";
import { guessHeading, guessUnit, listNames } from "./headings.ts";
import { listChoosable, proposeScenarios } from "./proposals.ts";
import { cutLog, findEnvelope, findRange, findTable, keepLog, orNull, readLog, readRecords, writeRecord, type LogRequest } from "./records.ts";
import type { TextColumn } from "./text-table.ts";
import { describeDifference, describeShown } from "./units.ts";

export { beginFit, cancelFit, listFits, watchFit } from "./job.ts";
export { isKept, keepLog } from "./records.ts";

const [SMALL, DRAWN, OVERLAID] = [120, 800, 400];

type Answer = (request: Record<string, unknown>) => Promise<unknown>;

export const answers: Record<string, Answer> = {
  table: async ({ key, separator }) => describeTable(key as string, separator as string),
  has_sample: async () => (await readManifest()).sample !== undefined,
  sample_log: placeSample,
  fit_records: async (request) => describeRecords(request as unknown as LogRequest),
  log_overlay: async (request) => overlayLogs(request as unknown as LogRequest & { align: string }),
  fit_starts: async () => ({ scenarios: [] }),
  fit_proposal: async (request) => proposeScenarios(readRecords(request as unknown as LogRequest)),
  fit_scenario: async (request) => describeFollowed(request as unknown as FollowRequest),
  /** Records as they are fitted, as text. */
  record_files: async (request) => readRecords(request as unknown as LogRequest).map((one) => ({ name: `${one.name}.csv`, text: writeRecord(one) })),
};

async function placeSample(): Promise<Uploaded> {
  const { sample } = await readManifest();
  if (!sample) throw new Refusal("This page has no log at hand.", "input", 404);
  const response = await fetchFile(locateFile(sample), sample);
  return keepLog(await response.blob(), sample);
}

/** Name and unit of every column; of two that mean the same, the second means nothing. */
function guessColumns(columns: TextColumn[]): { name: string; unit: string; guessed: boolean }[] {
  const taken = new Set<string>();
  return columns.map(({ heading, unit, numbers, clock }) => {
    const known = guessHeading(heading, unit);
    const name = clock ? "time" : known.name;
    if (!name || taken.has(name) || !numbers.some(Number.isFinite)) return { name: "", unit: known.unit, guessed: false };
    taken.add(name);
    const spelled = clock ? "s" : known.unit;
    return { name, unit: spelled || guessUnit(name, numbers), guessed: !spelled };
  });
}

function describeTable(key: string, separator: string): TableView {
  const { name, columns, rows, headed, preview, commas, notes, separator: chosen } = findTable(key, separator);
  const meant = guessColumns(columns);
  const unsure = meant.flatMap((one, at) => (one.guessed && one.name ? [at + 1] : []));
  const words = meant.filter((one) => one.name).map((one) => `\`${one.name}\`${one.unit ? ` in ${one.unit}` : ""}`);
  const unused = meant.length - words.length;
  const said = `Text with ${chosen}s${commas ? " and decimal commas" : ""}: ${words.join(", ") || "no column is recognised"}${unused ? `; ${unused} more ${unused > 1 ? "columns are" : "column is"} not used` : ""}.`;
  return {
    name, rows, headed, preview, said: said.replace("whitespaces", "blanks"), separator: chosen, names: listNames(),
    notes: [...(unsure.length ? [`Column ${unsure.join(", ")}: the unit is a guess by the values alone; look whether it is right.`] : []), ...notes],
    columns: columns.map(({ heading, numbers, wrong }, at) => {
      const [low, high] = findRange(numbers);
      const shown = findEnvelope(numbers, SMALL);
      const missing = numbers.reduce((sum, x) => sum + Number(Number.isNaN(x)), 0) - wrong.length;
      return {
        heading, name: meant[at]!.name, unit: meant[at]!.unit, min: orNull(low), max: orNull(high), missing,
        wrong: wrong.length, first_wrong: wrong[0] ?? "", curve: [shown, shown.map((row) => orNull(numbers[row]!))],
      };
    }),
  };
}

function describeRecords(request: LogRequest): RecordsView {
  const log = readLog(request);
  const columns = [...log.columns].map(([name, { si, values }]) => {
    const rows = findEnvelope(values, DRAWN);
    const missing = values.reduce((sum, x) => sum + Number(Number.isNaN(x)), 0);
    return { name, ...describeShown(name, si), times: rows.map((row) => log.times[row]!), values: rows.map((row) => orNull(values[row]!)), before: [], missing };
  });
  const cuts = request.cuts.map((cut) => {
    try {
      return { name: cut.name, rows: cutLog(log, cut).times.length, refused: "" };
    } catch (error) {
      return { name: cut.name, rows: 0, refused: (error as Error).message };
    }
  });
  return { begin: log.times[0]!, end: log.times.at(-1)!, rows: log.times.length, dropped: log.dropped, timed: log.timed, columns, steps: [], cuts };
}

/** All records over time, from the start of each or by their clocks. */
function overlayLogs(request: LogRequest & { align: string }): OverlayView {
  const records = readRecords(request).map((one) => ({ ...one, begin: request.align === "clock" ? 0 : one.times[0]! }));
  const ends = records.map(({ times, begin }) => [times[0]! - begin, times.at(-1)! - begin] as const);
  const [low, high] = [Math.min(...ends.map((one) => one[0])), Math.max(...ends.map((one) => one[1]))];
  const x = Array.from({ length: OVERLAID }, (_, k) => low + (k / (OVERLAID - 1)) * (high - low));
  const names = [...new Set(records.flatMap(({ columns }) => [...columns.keys()]))];
  const quantities = names.map((name) => {
    const si = records.map(({ columns }) => columns.get(name)?.si).find(Boolean)!;
    const lines = records.map(({ times, columns, begin }) => (columns.has(name) ? interpolateValues(times, columns.get(name)!.values, x.map((at) => at + begin)) : x.map(() => null)));
    return { name, ...describeShown(name, si), lines };
  });
  return { records: records.map((one) => one.name), axis: { name: "time", ...describeShown("time", "s") }, loops: false, x, quantities };
}

function interpolateValues(times: Float64Array, values: Float64Array, at: number[]): (number | null)[] {
  let row = 0;
  return at.map((time) => {
    while (row + 2 < times.length && times[row + 1]! < time) row++;
    const share = (time - times[row]!) / (times[row + 1]! - times[row]!);
    return share < -1e-9 || share > 1 + 1e-9 ? null : orNull(values[row]! + share * (values[row + 1]! - values[row]!));
  });
}

interface FollowRequest extends LogRequest {
  text: string;
  follow?: { path: string; column: string };
}

async function describeFollowed({ text, follow, ...request }: FollowRequest): Promise<ScenarioView> {
  const records = readRecords(request);
  const log = records[0]!;
  const followed = await readFollowed(follow ? followDrive(text, follow.path, follow.column) : text);
  const { scenario, follows, drives } = followed;
  const wrong = [...follows].find(([place, name]) => log.columns.get(name)?.si !== scenario.places.drives[place]!.how.unit);
  const outputs = matchOutputs(scenario, follows, log).map((name) => {
    const { unit } = scenario.outputs[name]!;
    return { name, ...describeShown(name, unit), difference: describeDifference(name, unit) };
  });
  const refused = scenario.layout.march === "given"
    ? "A controller in discrete time drives this scenario: the page fits none."
    : wrong
      ? `Column \`${wrong[1]}\` does not drive this scenario, which takes ${scenario.places.drives[wrong[0]]!.how.unit || "plain numbers"}.`
      : outputs.length ? "" : `No column of the log is an output of this scenario and varies; its outputs are ${Object.keys(scenario.outputs).join(", ")}.`;
  return {
    text: followed.text, title: scenario.title, described: scenario.described, refused, drives,
    columns: Object.fromEntries([...log.columns].map(([name, { si }]) => [name, si])),
    records: records.map((one) => one.name),
    numbers: listChoosable(followed).map(({ control: _, node: __, ...one }) => one),
    outputs, notes: [], methods: {}, losses: {},
  };
}
