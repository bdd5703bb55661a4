// Energies of a run over time; see martensite.simulate.energy.

import { ENERGIES, NO_ELEMENT, NO_WORK, PRESCRIBED } from "../engine/constants.ts";
import type { RunCore } from "../engine/types.ts";
import type { Energy } from "../lib/types.ts";
import { pickRows } from "./columns.ts";
import type { Numbers } from "./excursions.ts";
import { Computed, fillRow, type Values } from "./formulas.ts";
import type { Views } from "./types.ts";

export interface Energies {
  electrical: Float64Array;
  lost: Float64Array;
  /** Given while pulling, and taken back while stretched; null where ways are not known. */
  work: Float64Array | null;
  returned: Float64Array | null;
}

const label = (views: Views, port: string, name: string): string => (views.elements.prefixed ? `${port}.${name}` : name);

/** Energies up to every row that is drawn [J]; or why there are none. */
export function integrateEnergies(core: RunCore, { times, columns }: Pick<RunCore, "times" | "columns">, parameters: Values, views: Views): Energies | string {
  const ports = Object.entries(views.elements.ports);
  if (!ports.length) return NO_ELEMENT;
  if (ports.some(([, one]) => one.prescribed)) return PRESCRIBED;
  const given = core.track ?? core;
  const add = (name: string): Float64Array => {
    const sum = new Float64Array(given.times.length);
    for (const [port] of ports) {
      const own = given.columns[label(views, port, name)]!;
      for (let k = 0; k < sum.length; k++) sum[k]! += own[k]!;
    }
    return sum;
  };
  const total = (name: string, held: boolean): Float64Array => {
    const values = add(name);
    const sums = core.track && !held ? sumWeighted(core.track.weights, values) : integrate(given.times, values, held);
    return interpolate(times, given.times, sums);
  };
  const electrical = total("power", views.held);
  const lost = total("heat_loss", false);
  if (ports.some(([, one]) => one.way === null && one.length === null)) return { electrical, lost, work: null, returned: null };
  const known = new Computed(views.elements, parameters, columns, [0]);
  const [work, returned] = [new Float64Array(times.length), new Float64Array(times.length)];
  for (const [port, one] of ports) {
    const force = columns[label(views, port, "force")]!;
    const length = one.length === null ? 0 : known.one(one.length);
    const strain = columns[label(views, port, "strain")]!;
    const way = one.way === null ? fillRow(strain.length, (k) => -length * strain[k]!) : columns[one.way]!;
    const [given, taken] = sumWork(force, way);
    work.forEach((_, k) => {
      work[k]! += given[k]!;
      returned[k]! += taken[k]!;
    });
  }
  return { electrical, lost, work, returned };
}

function sumWork(force: Numbers, way: Numbers): [given: Float64Array, taken: Float64Array] {
  const [given, taken] = [new Float64Array(force.length), new Float64Array(force.length)];
  for (let k = 1; k < force.length; k++) {
    const done = 0.5 * (force[k]! + force[k - 1]!) * (way[k]! - way[k - 1]!);
    given[k] = given[k - 1]! + Math.max(done, 0);
    taken[k] = taken[k - 1]! + Math.max(-done, 0);
  }
  return [given, taken];
}

/** Integral up to every sample: of what holds for a period, or by trapezoids. */
function integrate(times: Numbers, values: Numbers, held: boolean): Float64Array {
  const found = new Float64Array(times.length);
  for (let k = 1; k < times.length; k++) {
    const middle = held ? values[k - 1]! : 0.5 * (values[k]! + values[k - 1]!);
    found[k] = found[k - 1]! + middle * (times[k]! - times[k - 1]!);
  }
  return found;
}

/** Sums of weighted values up to every row: all of the rows before it, and half of its own. */
function sumWeighted(weights: Float64Array, values: Float64Array): Float64Array {
  let sum = 0;
  return values.map((value, k) => {
    const own = weights[k]! * value;
    sum += own;
    return k === 0 ? 0 : k === values.length - 1 ? sum : sum - 0.5 * own;
  });
}

/** Values at ascending times, on straight lines between rows; the last one at the end. */
function interpolate(times: Float64Array, rows: Float64Array, values: Float64Array): Float64Array {
  let place = 0;
  return times.map((time, k) => {
    while (place + 2 < rows.length && rows[place + 1]! <= time) place++;
    if (k === times.length - 1 || rows.length < 2) return values[values.length - 1]!;
    const length = rows[place + 1]! - rows[place]!;
    const share = length > 0 ? Math.min(Math.max((time - rows[place]!) / length, 0), 1) : 1;
    return values[place]! + share * (values[place + 1]! - values[place]!);
  });
}

/** Work over electrical energy; no number without any. */
export const efficiencyAt = (found: Energies, k: number): number =>
  found.work && found.electrical[k]! > 0 ? found.work[k]! / found.electrical[k]! : NaN;

/** The courses that are drawn. */
export function describeEnergy(found: Energies | string, rows: number[]): Energy {
  if (typeof found === "string") return { courses: [], efficiency: null, sentence: found };
  const { electrical, lost, work, returned } = found;
  const course = (key: keyof typeof ENERGIES, values: Numbers) => {
    const [symbol, long_name, display_unit, factor] = ENERGIES[key];
    return { key, symbol, long_name, display_unit, factor, values: pickRows(values, rows) };
  };
  const courses = [course("electrical", electrical), course("lost", lost), course("stored", electrical.map((value, k) => value - lost[k]!))];
  if (!work || !returned) return { courses, efficiency: null, sentence: NO_WORK };
  courses.push(course("work", work), course("returned", returned));
  const share = (k: number): number | null => (electrical[k]! > 0 ? efficiencyAt(found, k) : null);
  return { courses, efficiency: rows.map(share), sentence: "" };
}
