// What is shown of a fit of the page: martensite.app.identify.fit_progress and fit_judgement, with the same words.

import type { Compared, Found, Note, Outcome, Parameter, Problem as ProblemView, Score, Verdict } from "../identify/types.ts";
import { digits, toShown } from "../lib/numbers.ts";
import { BOUNDED, CONVERGED, type Descent } from "./descent.ts";
import { writeNumbers, type Followed } from "./following.ts";
import { findSlope, toShare, toValue, type Curves, type FreeNumber, type Problem } from "./problem.ts";
import type { Choosable } from "./proposals.ts";
import { orNull, type LogRecord } from "./records.ts";
import { estimateUncertainty, type Uncertainty } from "./uncertainty.ts";
import { describeDifference, describeShown } from "./units.ts";

/** A number that is searched for, with what is said of it. */
export interface Free extends FreeNumber {
  of: Choosable;
}

/** All that a fit was asked. */
export interface Task {
  followed: Followed;
  records: LogRecord[];
  /** Outputs that are compared, of every record. */
  outputs: string[][];
  problem: Problem;
  free: Free[];
  /** What was done to the logs, and assumed. */
  prepared: string[];
  notes: string[];
  command: string;
}

export const INTERRUPTED = "interrupted";
const [POOR, NOTABLE, WORSE, MANY_LAGS] = [50, 0.05, 1.5, 0.3];
const AT_BOUND = 1e-4;
const BLIND = "The search was stopped before its first derivatives: what the log determines is not known.";
const [DRAWN, SHOWN] = [400, 800];

const quoteName = (name: string): string => `\`${name}\``;
const joinNames = (words: string[]): string => (words.length < 2 ? (words[0] ?? "") : `${words.slice(0, -1).join(", ")} and ${words.at(-1)!}`);

const pickRows = (count: number, most: number): number[] =>
  count <= most ? [...Array(count).keys()] : Array.from({ length: most }, (_, k) => Math.round((k * (count - 1)) / (most - 1)));

export function describeParameter({ of, start, low, high }: Free): Parameter {
  const { name, unit, shown, factor, offset, doc } = of;
  return { name, unit, shown, factor, offset, doc, record: null, start, low, high };
}

/** The problem as it is shown while a search goes on. */
export function describeProblem(task: Task, state: string): ProblemView {
  const records = task.problem.records.map(({ times, compared }, r) => {
    const rows = pickRows(times.length, DRAWN);
    const outputs = compared.map(({ measured }, k) => ({ ...nameOutput(task, r, k), measured: rows.map((row) => orNull(measured[row]!)) }));
    return { name: task.records[r]!.name, times: rows.map((row) => times[row]!), held: rows.map((row) => compared.every((one) => !one.used[row])), outputs };
  });
  return { parameters: task.free.map(describeParameter), records, noisy: [], notes: task.notes, state };
}

function nameOutput(task: Task, record: number, k: number): { name: string; long_name: string } & ReturnType<typeof describeShown> {
  const name = task.outputs[record]![k]!;
  const { unit, long_name } = task.followed.scenario.outputs[name]!;
  return { name, long_name, ...describeShown(name, unit) };
}

const listValues = (task: Task, shares: number[]): Record<string, number> => Object.fromEntries(task.free.map((free, k) => [free.of.name, toValue(free, shares[k]!)]));

export function describeNote(task: Task, now: Descent<Curves>, seconds: number): Note {
  const curves = now.extra.map((outputs) => outputs.map((one) => pickRows(one.length, DRAWN).map((row) => orNull(one[row]!))));
  const stage = now.reason ? "looking at the result" : "scenario";
  return { stage, cost: now.cost, simulations: now.runs, share: 0, seconds, values: listValues(task, now.shares), curves };
}

interface Judged {
  task: Task;
  now: Descent<Curves>;
  reason: string;
  found: Found[];
  scores: Score[];
  uncertainty: Uncertainty;
  weak: string[];
}

export function describeOutcome(task: Task, now: Descent<Curves>, apart: number, seconds: number, id: string): Outcome {
  const lengths = task.problem.records.flatMap(({ compared }) => compared.map(({ used }) => used.reduce((sum, x) => sum + x, 0))).filter(Boolean);
  const jacobian = now.jacobian.length ? now.jacobian : task.free.map(() => new Float64Array(now.residuals.length));
  const uncertainty = estimateUncertainty(now.residuals, jacobian, lengths, apart);
  const found = task.free.map((free, k) => describeFound(free, now.shares[k]!, k, uncertainty));
  const scores = listScores(task, now);
  const reason = now.reason || INTERRUPTED;
  const weak = now.jacobian.length ? describeWeak(found, uncertainty) : [BLIND];
  const judged: Judged = { task, now, reason, found, scores, uncertainty, weak };
  const values = Object.fromEntries(task.free.map((free, k) => [free.path, found[k]!.value]));
  const { followed } = task;
  const verdict = judgeFit(judged);
  const stretch = Math.max(...uncertainty.errors) * 100;
  const open = judged.weak.length ? judged.weak : [`${joinNames(found.map((one) => quoteName(one.name)))} ${found.length > 1 ? "are" : "is"} determined, the least certain to ± ${digits(stretch, 2)} % of its range of search.`];
  return {
    title: followed.scenario.title,
    verdict,
    prepared: task.prepared,
    command: task.command,
    reason,
    cost: now.cost,
    simulations: now.runs,
    jacobians: now.jacobians,
    seconds,
    parameters: found,
    own: {},
    scores,
    determined: found.every((one) => !one.mark),
    open,
    uncertainty: sayUncertain(judged),
    correlation: uncertainty.correlation,
    whiteness: listMemory(task, now),
    predictions: listPredictions(task, scores),
    warnings: [...listMisses(judged), ...listCare(judged)],
    notes: task.notes,
    history: now.history,
    rows: listRows(task, now),
    scenario: writeNumbers(followed.scenario, followed.own, values),
    followed: writeNumbers(followed.scenario, followed.text, values),
    fit: id,
  };
}

function describeFound(free: Free, share: number, k: number, { widened, weak }: Uncertainty): Found {
  const value = toValue(free, share);
  const half = widened[k]! * findSlope(free, value);
  const known = Number.isFinite(half);
  const bound = share <= AT_BOUND || share >= 1 - AT_BOUND;
  const wide = 2 * half > free.high - free.low;
  const faint = weak.some((one) => one.places.includes(k));
  const mark = !known ? "not determined" : bound ? "at a bound" : faint ? "weak" : wide || isImpossible(free, value, half) ? "not determined" : "";
  return { ...describeParameter(free), value, interval: known ? [value - half, value + half] : null, mark };
}

/** Whether an interval reaches values that a number cannot have, and is wide beside those that it can. */
function isImpossible({ of: { node } }: Free, value: number, half: number): boolean {
  const [least, most] = [node.low ?? -Infinity, node.high ?? Infinity];
  return (value - half < least || value + half > most) && !(2 * half < 0.5 * (most - least) && Number.isFinite(most - least));
}

/** Sentences about numbers that the log does not determine. */
function describeWeak(found: Found[], { weak, widened }: Uncertainty): string[] {
  const told = new Set(weak.flatMap((one) => one.places));
  return [
    ...weak.map(({ places, exact }) => {
      const names = places.map((k) => quoteName(found[k]!.name));
      if (names.length > 1) return `${joinNames(names)} are not determined separately: a change of one is made up for by the other${names.length > 2 ? "s" : ""}.`;
      return exact ? `${names[0]} is not determined: it has no effect on the error.` : `${names[0]} is not determined: its whole range changes the error by no more than noise.`;
    }),
    ...found.flatMap((one, k) => {
      if (told.has(k) || !one.mark || one.mark === "at a bound") return [];
      if (!Number.isFinite(widened[k]!)) return [`${quoteName(one.name)} is not determined: the data give it no interval.`];
      const half = (one.interval![1] - one.interval![0]) / 2;
      return [`${quoteName(one.name)} is not determined: its 95 % interval, ± ${sayChange(half, one)}, ${2 * half > one.high - one.low ? "is wider than the range in which it was searched" : "reaches values that it cannot have"}.`];
    }),
  ];
}

const sayChange = (value: number, how: { factor: number; shown: string }): string => `${digits(Math.abs(value * how.factor), 3)} ${how.shown === "degC" ? "K" : how.shown}`.trim();
const sayValue = (value: number, how: { factor: number; offset: number; shown: string }): string => `${digits(toShown(value, how), 5)} ${how.shown}`.trim();

// ---------------------------------------------------------------- scores

function listScores(task: Task, now: Descent<Curves>): Score[] {
  return task.problem.records.flatMap(({ times, compared }, r) =>
    compared.flatMap(({ measured, used }, k) => {
      const { name, unit } = nameOutput(task, r, k);
      const rows = [...measured.keys()].filter((row) => Number.isFinite(measured[row]!));
      const parts = [["training", rows.filter((row) => used[row])], ["held-out", rows.filter((row) => !used[row])]] as const;
      return parts.filter(([, own]) => own.length).map(([part, own]) => {
        const errors = own.map((row) => now.extra[r]![k]![row]! - measured[row]!);
        const mean = own.reduce((sum, row) => sum + measured[row]!, 0) / own.length;
        const size = Math.hypot(...errors);
        const varied = Math.hypot(...own.map((row) => measured[row]! - mean));
        const worst = errors.reduce((best, x, i) => (Math.abs(x) > Math.abs(errors[best]!) ? i : best), 0);
        return {
          record: task.records[r]!.name, output: name, part, rms: size / Math.sqrt(own.length), fit_percent: varied ? 100 * (1 - size / varied) : null,
          maximum: Math.abs(errors[worst]!), maximum_at: times[own[worst]!]!, bias: errors.reduce((sum, x) => sum + x, 0) / errors.length, ...describeDifference(name, unit),
        };
      });
    }),
  );
}

/** Error of an output over all records. */
function poolErrors(scores: Score[], output: string, part: string): number {
  const own = scores.filter((one) => one.output === output && one.part === part);
  return own.length ? Math.sqrt(own.reduce((sum, one) => sum + one.rms ** 2, 0) / own.length) : NaN;
}

function listPredictions(task: Task, scores: Score[]): string[] {
  return [...new Set(task.outputs.flat())].map((name) => {
    const how = describeDifference(name, task.followed.scenario.outputs[name]!.unit);
    const [seen, kept] = [poolErrors(scores, name, "training"), poolErrors(scores, name, "held-out")];
    const fitted = `${quoteName(name)}: rms error ${sayChange(seen, how)} in the rows that were fitted`;
    return Number.isNaN(kept) ? `${fitted}; none were kept back.` : `${fitted}, ${sayChange(kept, how)} in those kept back (${digits(kept / seen, 3)} times).`;
  });
}

/** How long residuals remember. */
function listMemory(task: Task, now: Descent<Curves>): string[] {
  return task.problem.records.flatMap(({ compared }, r) =>
    compared.flatMap(({ measured, used }, k) => {
      const errors = [...used.keys()].filter((row) => used[row]).map((row) => now.extra[r]![k]![row]! - measured[row]!);
      const total = errors.reduce((sum, x) => sum + x * x, 0);
      if (errors.length < 10 || !total) return [];
      const next = errors.slice(1).reduce((sum, x, i) => sum + x * errors[i]!, 0) / total;
      const where = quoteName(`${task.records[r]!.name}, ${task.outputs[r]![k]!}`);
      const words = next > MANY_LAGS ? "the model misses something, or the noise has a memory; intervals are widened for it" : "they look like noise from one row to the next";
      return [`${where}: residuals correlate by ${digits(next, 2)} from one row to the next: ${words}.`];
    }),
  );
}

function listRows(task: Task, now: Descent<Curves>): Compared[] {
  return task.problem.records.flatMap(({ times, compared }, r) =>
    compared.map(({ measured, used }, k) => {
      const rows = pickRows(times.length, SHOWN);
      const { name, ...how } = nameOutput(task, r, k);
      return {
        ...how, record: task.records[r]!.name, output: name, axis: null, times: rows.map((row) => times[row]!), measured: rows.map((row) => orNull(measured[row]!)),
        model: rows.map((row) => now.extra[r]![k]![row]!), held: rows.map((row) => !used[row]),
      };
    }),
  );
}

// ---------------------------------------------------------------- verdict

/** What speaks against the use of a fit. */
function listMisses({ task, scores }: Judged): string[] {
  const ranges = new Map(task.problem.records.flatMap(({ compared }, r) => compared.map(({ scale }, k) => [task.outputs[r]![k]!, scale] as const)));
  const poor = scores.filter((one) => one.fit_percent !== null && one.fit_percent < POOR && one.rms > NOTABLE * ranges.get(one.output)!);
  return poor.length ? [`The model explains less than half of what varies: ${joinNames(poor.map((one) => `${quoteName(one.output)} of ${one.record} (${digits(one.fit_percent, 3)} %)`))}.`] : [];
}

/** What asks for care. */
function listCare(judged: Judged): string[] {
  const { task, found, scores, reason, weak, uncertainty } = judged;
  const search = reason === CONVERGED || reason === BOUNDED ? [] : [`The search did not converge: ${reason}. The numbers are the best it came across.`];
  const bounds = found.filter((one) => one.mark === "at a bound").map((one) => {
    const low = toShare({ ...one, path: "", log: false }, one.value) < 0.5;
    return `${quoteName(one.name)} ended on its ${low ? "lower" : "upper"} bound, ${sayValue(low ? one.low : one.high, one)}: the bound decides and not the data. Widen it, or fix the number.`;
  });
  const kept = scores.some((one) => one.part === "held-out") ? [] : ["Nothing was kept back: how well the model predicts what it was not fitted to is not known."];
  const worse = [...new Set(task.outputs.flat())].flatMap((name) => {
    const [seen, other] = [poolErrors(scores, name, "training"), poolErrors(scores, name, "held-out")];
    return other > WORSE * seen ? [`${quoteName(name)} is predicted worse than it is fitted: its error in what was kept back is ${digits(other / seen, 3)} times that in what was fitted.`] : [];
  });
  const pairs = uncertainty.confounded.map(([i, j, value]) => `${quoteName(found[i]!.name)} and ${quoteName(found[j]!.name)} are hardly told apart (correlation ${value.toFixed(3)}): the interval of each holds with all others free to follow, and not for several at once.`);
  return [...search, ...bounds, ...kept, ...worse, ...weak, ...pairs];
}

function sayUncertain({ uncertainty, found, now }: Judged): string[] {
  const { samples, effective, errors } = uncertainty;
  const lost = !now.jacobian.length ? [] : found.filter((_, k) => errors[k] === Infinity).map((one) => quoteName(one.name));
  const widening = Math.sqrt(samples / effective);
  return [
    ...(lost.length ? [`The data do not determine ${joinNames(lost)}.`] : []),
    ...(widening > 1.1 ? [`The residuals are autocorrelated: ${samples} samples say as much as ${digits(effective, 2)} independent ones, so that errors are about ${digits(widening, 2)} times as large.`] : []),
  ];
}

function judgeFit(judged: Judged): Verdict {
  const { task, found, scores } = judged;
  const [against, care] = [listMisses(judged), listCare(judged)];
  const reasons = [...against, ...care];
  const word = against.length ? "not usable" : care.length ? "usable" : "good";
  const more = reasons.length > 1 ? ` (${reasons.length - 1} more below)` : "";
  const headline = word === "good"
    ? `Good: it predicts what it was not fitted to, and the logs determine all that was free. ${listPredictions(task, scores)[0]!}`
    : `${against.length ? "Not usable" : "Usable with care"}. ${reasons[0]!}${more}`;
  const told = found.filter((one) => !one.mark).map((one) => `${quoteName(one.name)} = ${sayValue(one.value, one)} (${sayValue(one.interval![0], one)} to ${sayValue(one.interval![1], one)})`);
  const untold = found.filter((one) => one.mark).map((one) => `${quoteName(one.name)}: ${one.mark}`);
  const next = untold.length ? ["A log in which what was not told matters: through the whole transformation and back, at another load or another rate; or fix what is known, and free less."] : [];
  return { word, headline, reasons, told, untold, next };
}
