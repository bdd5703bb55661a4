// Sentences on what a run did that should be known; see martensite.simulate.api and .alarms.

import { DOUBT_FRACTION, NOTICEABLE } from "../engine/constants.ts";
import { writeCompression, writeDoubt, writeGuard } from "../engine/sentences.ts";
import type { RunCore } from "../engine/types.ts";
import type { Alarm } from "../lib/types.ts";
import { highest, lowest } from "./columns.ts";
import type { Numbers } from "./excursions.ts";
import { Computed, type Values } from "./formulas.ts";
import type { Doubt, LawWords, Views } from "./types.ts";

/** What the march says, alarms, doubts about laws, and what the guard did. */
export function listWarnings(core: RunCore, views: Views, values: Values, alarms: Alarm[]): string[] {
  const doubts = views.laws.flatMap((law) => describeDoubts(core, views, values, law));
  return [
    ...core.warnings,
    ...alarms.map((one) => one.sentence),
    ...new Set(doubts),
    ...describeGuard(core, views),
  ];
}

function describeDoubts(core: RunCore, views: Views, values: Values, law: LawWords): string[] {
  const column = (name: string): Numbers => (core.track ?? core).columns[views.elements.prefixed ? `${law.port}.${name}` : name]!;
  const stress = column("stress");
  const found: string[] = [];
  if (law.loops && countOpenTurns(column("martensite_fraction")) >= 2 * law.loops)
    found.push(
      `Caution: \`${law.name}\` remembers ${law.loops} loops within each other; whether it forgot any of this run is not judged in the page.`,
    );
  if (law.tension && lowest(stress) <= -NOTICEABLE)
    found.push(writeCompression(lowest(stress), law.name, law.symmetric));
  return [...found, ...describeDoubt(views.doubts[law.port] ?? [], values, Math.max(highest(stress), -lowest(stress)))];
}

function describeDoubt(doubts: Doubt[], values: Values, most: number): string[] {
  for (const one of doubts) {
    const known = new Computed(one, values);
    if (!known.holds) continue;
    if (one.stress === null || one.sentence === null || !(most > DOUBT_FRACTION * known.one(one.stress))) return [];
    return [writeDoubt(known.write(one.sentence), most)];
  }
  return doubts.length ? ["Caution: the page does not know the stress limit of this law for these parameters."] : [];
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

/** What the guard of a loop did. */
function describeGuard(core: RunCore, { guard }: Views): string[] {
  const { times, columns } = core.track ?? core;
  const raised = guard && columns[guard.column];
  if (!raised) return [];
  const lengthAt = (k: number): number => (k + 1 < times.length ? times[k + 1]! - times[k]! : guard.period);
  return [...new Set(raised)].filter(Boolean).sort((a, b) => a - b).map((number) => {
    const duration = raised.reduce((sum, value, k) => (value === number ? sum + lengthAt(k) : sum), 0);
    const names = (guard.checks[String(Math.trunc(number) % guard.limited)] ?? ["supervisor"]).map((name) => `\`${name}\``).join(", ");
    return writeGuard(number, guard.limited, names, times[raised.indexOf(number)]!, duration);
  });
}
