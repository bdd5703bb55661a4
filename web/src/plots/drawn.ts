// Which runs are drawn, and what of them: columns in shown units, ports, limits of time.

import { computed, signal } from "@preact/signals";
import { toShown } from "../lib/numbers.ts";
import type { Output, Run } from "../lib/types.ts";
import { before, pinned, run } from "../state/run.ts";
import { keepPart } from "../state/session.ts";
import { pinLook, type Look } from "./palette.ts";

/** Pinned runs that are not drawn. */
export const hidden = signal<ReadonlySet<number>>(new Set());

export interface Beside {
  id: number;
  name: string;
  run: Run;
  look: Look;
}

/** Pinned runs that are drawn beneath the live one. */
export const beside = computed<Beside[]>(() => [
  ...(before.value ? [{ id: 0, name: before.value.title, run: before.value, look: BEFORE }] : []),
  ...pinned.value
    .filter((one) => !hidden.value.has(one.id))
    .map((one) => ({ id: one.id, name: one.name, run: one.run, look: pinLook(one.id) })),
]);

/** The run from which a model was taken up by hand. */
const BEFORE: Look = { colour: 5, dash: [2, 4], width: 1 };

/** The port that is drawn; empty for all of them. Null: not chosen yet. */
export const portChoice = signal<string | null>(null);
/** More ports than these are not drawn together unless that is asked for. */
const MANY = 3;

export function portsOf(of: Run): string[] {
  const choice = portChoice.value;
  if (choice && of.ports.includes(choice)) return [choice];
  const first = of.ports.slice(0, 1);
  return choice === "" || (choice === null && of.ports.length <= MANY) ? of.ports : first;
}

/** Panels that are shown, where that differs from what is usual: by key. */
export const panelChoice = signal<Readonly<Record<string, boolean>>>({});

/** Part of the time that is shown [s]; null for all. */
export const zoom = signal<[number, number] | null>(null);

interface View {
  hidden: number[];
  port: string | null;
  panels: Record<string, boolean>;
  zoom: [number, number] | null;
}

keepPart(
  "view",
  (): View => ({ hidden: [...hidden.value], port: portChoice.value, panels: panelChoice.value, zoom: zoom.value }),
  (kept) => {
    const found = kept as Partial<View>;
    const [from, to] = Array.isArray(found.zoom) ? found.zoom : [];
    hidden.value = new Set(Array.isArray(found.hidden) ? found.hidden : []);
    portChoice.value = typeof found.port === "string" ? found.port : null;
    panelChoice.value = typeof found.panels === "object" ? found.panels : {};
    zoom.value = typeof from === "number" && typeof to === "number" && from < to ? [from, to] : null;
  },
);

export const duration = (of: Run): number => of.times.at(-1) ?? 0;

/** End of the longest run that is drawn [s]. */
export const wholeTime = computed<number>(
  () => Math.max(...[run.value, ...beside.value.map((one) => one.run)].map((one) => (one ? duration(one) : 0))) || 1,
);

export const timeLimits = computed<[number, number]>(() => zoom.value ?? [0, wholeTime.value]);

const kept = new WeakMap<Run, Map<string, Float64Array>>();

/** Numbers in SI as they are shown. */
export function shownValues(values: ArrayLike<number | null>, how: { factor: number; offset: number }): Float64Array {
  const found = new Float64Array(values.length);
  for (let i = 0; i < values.length; i++) {
    const value = values[i];
    found[i] = value === null || value === undefined ? NaN : toShown(value, how);
  }
  return found;
}

/** A column as it is shown; made once for every run. */
export function shownColumn(of: Run, name: string): Float64Array {
  let known = kept.get(of);
  if (!known) kept.set(of, (known = new Map()));
  let found = known.get(name);
  const how = of.outputs[name];
  if (!found) known.set(name, (found = how ? shownValues(of.columns[name] ?? [], how) : new Float64Array()));
  return found;
}

const PRINTED: Record<string, string> = { degC: "°C", deg: "°", ohm: "Ω", "deg/s": "°/s" };

/** A unit as it is printed. */
export const printed = (unit: string): string => PRINTED[unit] ?? unit.replaceAll("*", "·").replaceAll("^2", "²").replaceAll("^3", "³");

/** Symbol and unit of an axis, such as T [°C]. */
export const axisLabel = (how: Pick<Output, "symbol" | "display_unit">): string =>
  `${how.symbol.replace("_", " ")} [${printed(how.display_unit) || "–"}]`;

/** Height of what stands above and between the planes, and of the bar at the end of a small screen [px]. */
const [ABOVE, BAR, SMALL] = [430, 70, 1100];

/** Height of the planes beside the mechanism, two of which fit on the screen with what is above them [px]. */
export const planeHeight = signal(heightNow());
addEventListener("resize", () => (planeHeight.value = heightNow()));

function heightNow(): number {
  const free = innerHeight - ABOVE - (innerWidth <= SMALL ? BAR : 0);
  return Math.round(Math.min(Math.max(free / 2, 150), 320));
}
