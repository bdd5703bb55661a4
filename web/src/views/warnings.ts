// Sentences on what a run did that should be known; see martensite.simulate.api and .alarms.

import type { RunCore } from "../engine/types.ts";
import type { Alarm } from "../lib/types.ts";
import { highest, lowest } from "./columns.ts";
import type { Numbers } from "./excursions.ts";
import { Computed, general, type Values } from "./formulas.ts";
import type { Described } from "./run.ts";
import type { Doubt, LawWords, Views } from "./types.ts";

/** Share of a stress from which a law is doubtful, from which on it is said. */
const NEAR = 0.8;
/** Compression [Pa] from which on it is said that a law knows tension only. */
const NOTICEABLE = 5e6;
/** Energies [J] that are nothing to balance. */
const LEAST_HEAT = 1e-9;
const LEAST_WORK = 1e-12;

/** In the order in which a run in Python says them. */
export function listWarnings(core: RunCore, scenario: Described, values: Values, alarms: Alarm[]): string[] {
  const { views } = scenario;
  const doubts = views.laws.flatMap((law) => describeDoubts(core, views, values, law));
  return [
    ...describeBalances(core, scenario),
    ...describeExit(core, views),
    ...alarms.map((one) => one.sentence),
    ...(core.status === "LONG_STEP" ? [`Warning: ${views.long_step}`] : []),
    ...new Set(doubts),
    ...describeAccuracy(core),
    ...describeGuard(core, views),
    ...describeEnd(core, views),
  ];
}

function describeDoubts(core: RunCore, views: Views, values: Values, law: LawWords): string[] {
  const column = (name: string): Numbers => core.columns[views.elements.prefixed ? `${law.port}.${name}` : name]!;
  const stress = column("stress");
  const found: string[] = [];
  if (law.loops && countOpenTurns(column("martensite_fraction")) >= 2 * law.loops)
    found.push(
      `Caution: \`${law.name}\` remembers ${law.loops} loops within each other; whether it forgot any of this run is not judged in the page.`,
    );
  if (law.tension && lowest(stress) <= -NOTICEABLE)
    found.push(
      `Caution: the stress falls to ${general(lowest(stress) / 1e6, 4)} MPa, but \`${law.name}\` knows tension only, and compression drives ` +
        `its martensite back${law.symmetric ? '; try `compression = "symmetric"` of the law' : ""}.`,
    );
  return [...found, ...describeDoubt(views.doubts[law.port] ?? [], values, Math.max(highest(stress), -lowest(stress)))];
}

function describeDoubt(doubts: Doubt[], values: Values, most: number): string[] {
  for (const one of doubts) {
    const known = new Computed(one, values);
    if (!known.holds) continue;
    if (one.stress === null || one.sentence === null || !(most > NEAR * known.one(one.stress))) return [];
    return [`Caution: ${known.write(one.sentence)} The stress comes to ${general(most / 1e6, 4)} MPa.`];
  }
  return doubts.length ? ["Caution: from which stress on this law is doubtful is not known in the page for its numbers."] : [];
}

/** The most turning points at a time that are not wiped out by a larger loop around them. */
function countOpenTurns(values: Numbers): number {
  const open: number[] = [values[0]!];
  let [most, sense] = [0, 0];
  const size = (k: number): number => Math.abs(open.at(-k)! - open.at(-k - 1)!);
  for (let k = 1; k < values.length; k++) {
    const now = Math.sign(values[k]! - values[k - 1]!);
    if (now && now === sense) open.pop();
    if (now) open.push(values[k]!);
    sense = now || sense;
    while (open.length > 2 && size(1) >= size(2)) open.splice(-3, 2);
    most = Math.max(most, open.length);
  }
  return most;
}

function describeBalances(core: RunCore, { views, accounts }: Described): string[] {
  const own = (name: string): number => core.accounts[accounts.indexOf(name)] ?? 0;
  const stored = own("sensible") + own("latent");
  const held = own("springs") + own("gravity") + own("kinetic") + own("magnetic");
  const share = {
    heat: [Math.abs(core.putIn - core.lost - stored), Math.max(Math.abs(core.putIn), Math.abs(core.lost), Math.abs(stored)), LEAST_HEAT],
    work: [
      Math.abs(own("work") - held - own("dissipated") - own("outside")),
      Math.max(own("exchanged"), Math.abs(held), Math.abs(own("dissipated"))),
      LEAST_WORK,
    ],
  } as const;
  return views.balances.flatMap((words) => {
    const [missing, most, least] = share[words];
    if (!(most > least) || missing / most <= core.tolerance) return [];
    return [`Warning: ${exponential(missing / most)} of the ${words} is not accounted for, more than the tolerance of ${exponential(core.tolerance)}.`];
  });
}

function describeExit({ exit }: RunCore, { exits }: Views): string[] {
  if (!exit) return [];
  const { words, shown, size, zero, reason } = exits[exit.place]!;
  const bound = exit.value > 0 ? exit.high : exit.low;
  const told = (value: number): string => `${general((value - zero) / size, 5)} ${shown}`;
  const beyond = zero > 0 && exit.value <= 0 ? "absolute zero" : reason;
  return [`The run stopped at t = ${general(exit.time, 6)} s: the ${words} came to ${told(exit.value)}, beyond ${told(bound)}, ${beyond}.`];
}

function describeAccuracy({ accuracy, tolerance, steps, status }: RunCore): string[] {
  if (accuracy === null || accuracy <= tolerance || status === "OUT_OF_ENVELOPE") return [];
  return [
    `Warning: the tolerance of ${exponential(tolerance)} was not reached in ${steps.toLocaleString("en-US")} steps; ` +
      `what is judged may be off by ${exponential(accuracy)} of its range.`,
  ];
}

/** What the guard of a loop did. */
function describeGuard(core: RunCore, { guard }: Views): string[] {
  const raised = guard && core.columns[guard.column];
  if (!raised) return [];
  return [...new Set(raised)].filter(Boolean).sort((a, b) => a - b).map((number) => {
    const samples = raised.filter((value) => value === number).length;
    const names = (guard.checks[String(Math.trunc(number) % guard.limited)] ?? ["supervisor"]).map((name) => `\`${name}\``).join(", ");
    return (
      `Warning: The guard ${number > guard.limited ? "limited" : "cut"} a signal by ${names} (alarm ${number.toFixed(0)}), ` +
      `first at t = ${general(core.times[raised.indexOf(number)]!, 4)} s, for ${general(guard.period * samples, 3)} s in all.`
    );
  });
}

/** A run in periods that ends at another time than was asked for. */
function describeEnd({ times, duration, status }: RunCore, { period }: Views): string[] {
  const end = times.at(-1)!;
  if (!period || status === "OUT_OF_ENVELOPE" || Math.abs(end - duration) <= 1e-6 * duration) return [];
  const told = (value: number): string => general(value, 6);
  return [
    `Warning: The run ends at ${told(end)} s instead of ${told(duration)} s: it goes in periods of ${told(period)} s. ` +
      "Try a duration that is a multiple of it.",
  ];
}

/** As Python writes it with the format `.1e`. */
const exponential = (value: number): string =>
  value.toExponential(1).replace(/e([+-])(\d)$/, "e$10$2");
