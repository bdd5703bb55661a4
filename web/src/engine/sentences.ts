// Written by write_types.py from declarations in Python; do not edit.

import { formatGeneral, formatPower } from "../views/formulas.ts";

export const writeExcursion = (first: number, duration: number): string =>
  `first at t = ${formatGeneral(first, 4)} s, for ${formatGeneral(duration, 3)} s in all`;
export const writeLimitAlarm = (kind: string, worst: number, zero: number, scale: number, readableUnit: string, limit: number, when: string): string =>
  `Warning: ${kind} reaches ${formatGeneral((worst - zero) / scale, 4)} ${readableUnit}, above the \`${kind}_limit\` of ${formatGeneral((limit - zero) / scale, 4)} ${readableUnit}, ${when}.`;
export const writeStrainAlarm = (worst: number, limit: number, when: string): string =>
  `Warning: strain varies by ${formatGeneral(100 * worst, 3)} %, more than the \`strain_limit\` of ${formatGeneral(100 * limit, 3)} %, ${when}.`;
export const writeSlackAlarm = (when: string): string =>
  `Warning: the element is slack (no force), ${when}.`;
export const writeSourceAlarm = (registeredName: string, time: number, limit: number, unit: string, worst: number, when: string): string =>
  `Warning: the drive \`${registeredName}\` cannot deliver what is demanded, at t = ${formatGeneral(time, 4)} s only ${formatGeneral(limit, 4)}${unit === "1" ? "" : ` ${unit}`} of ${formatGeneral(worst, 4)}${unit === "1" ? "" : ` ${unit}`}, ${when}.`;
export const writeSupplyAlarm = (worst: number, times: number, limit: number, supplyVoltage: number, when: string): string =>
  `Warning: the sources ask the supply for ${formatGeneral(worst, 4)} A at t = ${formatGeneral(times, 4)} s, more than its \`current_limit\` of ${formatGeneral(limit, 4)} A; its voltage falls to ${formatGeneral(supplyVoltage, 4)} V, ${when}.`;
export const writeDriftAlarm = (start: number, long: string, share: number, times: number, short: string): string =>
  `Warning: the first cycle drifts: ${formatGeneral(100 * start, 3)} % of the martensite is oriented at the start (strain ${long}), ${formatGeneral(100 * share, 3)} % at t = ${formatGeneral(times, 4)} s (strain ${short}); use later cycles.`;
export const writeDoubt = (sentence: string, most: number): string =>
  `Caution: ${sentence} The stress comes to ${formatGeneral(most / 1e+06, 4)} MPa.`;
export const writeCompression = (least: number, registeredName: string, hasCompression: boolean): string =>
  `Caution: the stress falls to ${formatGeneral(least / 1e+06, 4)} MPa, but \`${registeredName}\` knows tension only, and compression drives its martensite back${hasCompression ? "; try `compression = \"symmetric\"` of the law" : ""}.`;
export const writeDecision = (time: number, port: string, margin: number, branch: number, error: number, change: number): string =>
  `Warning: at t = ${formatGeneral(time, 6)} s${port ? `, element \`${port}\`` : ""}, the path ${margin >= 0 ? "misses" : "passes"} the start of the ${branch > 0 ? "reverse" : "forward"} transformation (${branch > 0 ? "A_s" : "M_s"}) by ${formatPower(Math.abs(margin))} K, and the error of the run is up to ${formatPower(error)} K. There the law forgets the interrupted ${branch > 0 ? "forward" : "reverse"} transformation, so the martensite fraction may be wrong by up to ${formatGeneral(change, 2)}; the stated error includes this. Give a smaller tolerance, change the drive or the load a little, or use \`history = "return-point"\` of the law.`;
export const writeMissed = (tolerance: number, steps: number, accuracy: number): string =>
  `Warning: the tolerance of ${formatPower(tolerance)} was not reached in ${steps.toLocaleString("en")} steps; what is judged may be off by ${formatPower(accuracy)} of its range.`;
export const writeResidual = (residual: number, words: string, tolerance: number): string =>
  `Warning: ${formatPower(residual)} of the ${words} is not accounted for, more than the tolerance of ${formatPower(tolerance)}.`;
export const writeFailure = (statusTime: number | null, sentence: string): string =>
  `The coupled step of law, heat and mechanism failed ${statusTime === null ? "during the run" : `at t = ${formatGeneral(statusTime, 6)} s`}. ${sentence}`;
export const writeStop = (time: number, describeBound: string): string =>
  `The run stopped at t = ${formatGeneral(time, 6)} s: ${describeBound}`;
export const writeBound = (words: string, where: string, value: number, bound: number, limit: string, excess: string, reason: string): string =>
  `the ${words}${where} reached ${value === bound ? limit : `${excess}, beyond ${limit}`} (${reason}).`;
export const writeGuard = (number: number, limited: number, names: string, first: number, length: number): string =>
  `Warning: The guard ${number > limited ? "limited" : "cut"} a signal by ${names} (alarm ${number.toFixed(0)}), first at t = ${formatGeneral(first, 4)} s, for ${formatGeneral(length, 3)} s in all.`;
export const writeEnd = (end: number, duration: number, period: number): string =>
  `Warning: The run ends at ${formatGeneral(end, 6)} s instead of ${formatGeneral(duration, 6)} s: it goes in periods of ${formatGeneral(period, 6)} s. Try a duration that is a multiple of it.`;
export const writeSupervisor = (first: number, duration: number): string =>
  `Warning: the supervisor raised its alarm, first at t = ${formatGeneral(first, 4)} s, for ${formatGeneral(duration, 3)} s in all.`;
