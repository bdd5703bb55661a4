// A fit as it is asked for, and what the search needs of it.

import { SERVER } from "../engine/inputs.ts";
import type { Choice } from "../identify/state.ts";
import { Refusal } from "../lib/refusal.ts";
import { matchOutputs, readFollowed, type Followed } from "./following.ts";
import type { FittedRecord } from "./problem.ts";
import type { Free, Task } from "./outcome.ts";
import { isLogarithmic, listChoosable, MOST_FREE } from "./proposals.ts";
import { findRange, readRecords, type LogRecord, type LogRequest } from "./records.ts";
import { followColumn, makeSegments } from "./waveforms.ts";

export interface FitRequest extends LogRequest {
  text: string;
  free: ({ name: string } & Choice)[];
  each: { name: string }[];
  /** Outputs that are compared; all that could be if empty. */
  compare: string[];
  hold_out: string | string[];
}

/** Stretches of a record that are kept back, of twenty equally long ones: those of \`martensite fit\`. */
const [STRETCHES, KEPT, MANY_RECORDS] = [20, [4, 9, 14, 19], 3];

export async function arrangeFit(request: FitRequest): Promise<Task> {
  const records = readRecords(request);
  const followed = await readFollowed(request.text);
  if (followed.scenario.layout.march === "given") throw new Refusal(`This page fits no scenario with a controller in discrete time. ${SERVER}`, "server", 501);
  if (request.each.length) throw new Refusal(`This page fits no numbers that every record has for itself. ${SERVER}`, "server", 501);
  const outputs = records.map((record) => chooseOutputs(followed, record, request.compare));
  const free = chooseFree(followed, request.free);
  const ranges = measureRanges(records, outputs);
  const held = holdOut(request.hold_out, records);
  const made = records.map((record, k) => buildRecord(followed, record, outputs[k]!, ranges, held[k]!));
  const problem = { changes: followed.changes, free: free.map(({ of: _, ...one }) => one), records: made.map((one) => one.fitted) };
  const steady = [...new Set(made.flatMap((one) => one.held))].map((name) => `Column \`${name}\` is held: each level acts from its row on until the next.`);
  return {
    followed, records, outputs, problem, free,
    prepared: [...records.map((record) => describeRecord(record)), ...steady, "Fitted in this page: derivatives are differences of runs, and noise in what drives does not count."],
    notes: steady,
    command: writeCommand(request, records, outputs, followed, free),
  };
}

function chooseOutputs(followed: Followed, record: LogRecord, wanted: string[]): string[] {
  const missing = [...followed.follows.values()].find((name) => !record.columns.has(name));
  if (missing) throw new Refusal(`Record \`${record.name}\` has no column \`${missing}\`, which the scenario follows.`, "input", 400);
  const found = matchOutputs(followed.scenario, followed.follows, record).filter((name) => !wanted.length || wanted.includes(name));
  if (!found.length) throw new Refusal(`Record \`${record.name}\` has no column that is an output of this scenario and varies.`, "input", 400);
  return found;
}

function chooseFree(followed: Followed, asked: FitRequest["free"]): Free[] {
  if (!asked.length) throw new Refusal("Choose at least one number to be found.", "input", 400);
  if (asked.length > MOST_FREE) throw new Refusal(`This page fits up to ${MOST_FREE} numbers, and ${asked.length} are free. ${SERVER}`, "server", 501);
  const known = listChoosable(followed);
  const found = asked.map(({ name, start, low, high, scale }): Free => {
    const of = known.find((one) => one.name === name || one.control.path === name);
    if (!of) throw new Refusal(`This page cannot change \`${name}\` by itself. ${SERVER}`, "server", 501);
    const ends = [Math.max(low ?? of.low!, of.low!), Math.min(high ?? of.high!, of.high!)] as const;
    const begin = start ?? of.value;
    if (!(ends[0] < ends[1])) throw new Refusal(`\`${name}\`: the bounds leave nothing between them.`, "input", 400);
    if (begin < ends[0] || begin > ends[1]) throw new Refusal(`\`${name}\` starts outside of its bounds.`, "input", 400);
    const log = scale ? scale === "log" : isLogarithmic(...ends);
    return { path: of.control.path, start: begin, low: ends[0], high: ends[1], log: log && ends[0] > 0, of };
  });
  refuseApart(followed, found);
  return found;
}

function refuseApart({ scenario: { controls, apart } }: Followed, found: Free[]): void {
  const pair = apart.find((two) => two.every((k) => found.some((one) => one.path === controls[k]!.path)));
  if (!pair) return;
  const names = pair.map((k) => `\`${controls[k]!.path}\``).join(" and ");
  throw new Refusal(`This page cannot change ${names} together: free one of them. ${SERVER}`, "server", 501);
}

/** Range of every output over all records: what residuals are divided by. */
function measureRanges(records: LogRecord[], outputs: string[][]): Map<string, number> {
  const found = new Map<string, number>();
  records.forEach(({ columns }, k) => outputs[k]!.forEach((name) => {
    const [low, high] = findRange(columns.get(name)!.values);
    found.set(name, Math.max(found.get(name) ?? 0, high - low));
  }));
  return found;
}

/** For every record whether a time [s] in it is kept back. */
function holdOut(rule: string | string[], records: LogRecord[]): ((time: number) => boolean)[] {
  const share = typeof rule === "string" ? /^\s*([\d.]+)\s*%\s*$/.exec(rule)?.[1] : undefined;
  return records.map(({ name, times }, k) => {
    const length = times.at(-1)! - times[0]!;
    if (Array.isArray(rule)) return () => rule.includes(name);
    if (share) return (time) => time >= times.at(-1)! - (Number(share) / 100) * length;
    if (rule !== "auto") return () => false;
    if (records.length >= MANY_RECORDS) return () => k === Math.floor(records.length / 2);
    return (time) => KEPT.some((at) => time >= times[0]! + (at / STRETCHES) * length && time <= times[0]! + ((at + 1) / STRETCHES) * length);
  });
}

function buildRecord({ scenario, follows }: Followed, { times, columns }: LogRecord, outputs: string[], ranges: Map<string, number>, held: (time: number) => boolean): { fitted: FittedRecord; held: string[] } {
  const steady: string[] = [];
  const drives = [...follows].map(([place, name]): FittedRecord["drives"][number] => {
    const { si, values } = columns.get(name)!;
    const wanted = scenario.places.drives[place]!.how.unit;
    if (si !== wanted) throw new Refusal(`Column \`${name}\` is in ${si}, but what follows it takes ${wanted}.`, "input", 400);
    const { rows, held: stays } = followColumn(times, values, si);
    if (rows.length < 2) throw new Refusal(`Column \`${name}\` holds fewer than two numbers.`, "input", 400);
    if (stays) steady.push(name);
    return [place, makeSegments(rows)];
  });
  const compared = outputs.map((name) => {
    const measured = columns.get(name)!.values;
    const used = Uint8Array.from(times, (time, row) => Number(Number.isFinite(measured[row]!) && !held(time)));
    return { at: scenario.names.indexOf(name), measured, scale: ranges.get(name)!, used };
  });
  return { fitted: { times: times.map((time) => time - times[0]!), drives, compared }, held: steady };
}

const describeRecord = ({ name, times, timed, dropped }: LogRecord): string =>
  `\`${name}\`: ${times.length.toLocaleString("en")} rows${timed ? "" : ", each taken as one interval"}${dropped ? `; ${dropped} that could not be read are left out` : ""}.`;

/** The command that repeats the fit with the files that the page saves. */
function writeCommand({ hold_out }: FitRequest, records: LogRecord[], outputs: string[][], { scenario, follows }: Followed, free: Free[]): string {
  const quoted = (word: string): string => (/^[\w.,/=-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);
  const unit = (one: Free): string => (one.of.unit === "1" ? "" : ` ${one.of.unit}`);
  const number = (value: number): number => Number(value.toPrecision(10));
  const range = (one: Free): string => `${one.of.name}=${number(one.low)}..${number(one.high)}${unit(one)}@${number(one.start)}${unit(one)}${one.log ? " log" : ""}`;
  const words = ["martensite", "fit", ...records.map(({ name }) => `${name}.csv`), "--scenario", "scenario.toml", "--free", free.map(range).join(",")];
  const all = new Set(records.flatMap((record) => matchOutputs(scenario, follows, record)));
  const chosen = new Set(outputs.flat());
  if (chosen.size < all.size) chosen.forEach((name) => words.push("--column", name));
  const kept = Array.isArray(hold_out) ? hold_out.join(",") : hold_out;
  if (kept !== "auto") words.push("--hold-out", kept);
  return words.map(quoted).join(" ");
}
