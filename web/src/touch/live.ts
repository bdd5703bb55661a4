// The model running forward by hand: it steps with the clock, under what is held and dragged meanwhile.

import { batch, effect, signal } from "@preact/signals";
import { readSignal } from "../engine/drives.ts";
import { predictInputs, type Changes } from "../engine/inputs.ts";
import type { AskedStep, Stepped } from "../engine/worker.ts";
import type { DriveAt, Scenario } from "../engine/types.ts";
import { sentence } from "../lib/api.ts";
import { startWorker } from "../lib/host.ts";
import type { Run } from "../lib/types.ts";
import { before, cursor, run } from "../state/run.ts";
import { text } from "../state/scenario.ts";
import { pause, rate } from "../scene/playing.ts";
import { shownStage } from "../scene/shown.ts";
import { clampLoad, dragLoad, findLoad, type Load } from "./handles.ts";
import { findModel, type Model } from "./model.ts";
import { Recording } from "./recording.ts";

/** A drive as it is held: its level while it is [SI], and the most that its slider gives. */
export interface Source {
  drive: DriveAt;
  /** Heat while it is held, the set point of a controller, or a signal of the document, such as noise. */
  kind: "heat" | "setpoint" | "document";
  strength: number;
  most: number;
  /** Share of its strength that it gives now. */
  share: number;
}

/** What is run by hand. */
export interface Hand {
  model: Model;
  recording: Recording;
  drives: Source[];
  load: Load | null;
}

export const hand = signal<Hand | null>(null);
/** Whether the model is being fetched or compiled. */
export const preparing = signal(false);
/** Why it does not run, or what stopped it. */
export const said = signal("");
/** Counts what the panel shows again. */
export const turned = signal(0);

/** Whether the model keeps to the clock, whatever the speed that is chosen. */
export const inRealTime = signal(false);
/** Those who look at a recording after each span. */
export const watchers = new Set<(now: Hand) => void>();

/** Longest step of the clock that counts [s]. */
const LONGEST = 0.1;
/** Samples in the time of the packaged run, at least. */
const FINE = 800;
const MOST_PARTS = 20;
/** The slider of a drive goes up to so many times the most of the document. */
const ROOM = 2;
/** Share of the largest set point of the document with which a controller begins. */
const BEGUN = 0.75;
/** Between pictures where motion is to be reduced [ms]. */
const CALM = 500;
/** Sentences of a refused step stand so long [ms]. */
const STANDS = 4000;

let worker: Worker | null = null;
let answered: ((found: Stepped) => void) | null = null;
let changed = false;
let clock = 0;
let drawn = 0;
let spoken = 0;
let frame = 0;
let busy = false;
let shown: Run | null = null;
let moved = false;
const begun = { run: null as Run | null, hand: null as Hand | null };
const calm = (): boolean => matchMedia("(prefers-reduced-motion: reduce)").matches;

function ask(asked: AskedStep): Promise<Stepped> {
  return new Promise((resolve) => {
    answered = resolve;
    worker!.postMessage(asked);
  });
}

async function renewWorker(): Promise<void> {
  worker?.terminate();
  worker = await startWorker("engine.js");
  worker.onmessage = (event: MessageEvent<Stepped>) => answered?.(event.data);
  worker.onerror = () => answered?.({ refused: "The calculation ended unexpectedly; try again." });
}

/** Levels of a drive [SI] in the document: the most of them. */
function mostOf(scenario: Scenario, drive: DriveAt, inputs: Float64Array): number {
  const duration = inputs[scenario.places.duration]!;
  const times = Float64Array.from({ length: 400 }, (_, k) => (duration * k) / 399);
  return readSignal(scenario, drive, inputs, times).reduce((a, b) => Math.max(a, Math.abs(b)), 0);
}

function listDrives({ scenario, changes }: Model): Source[] {
  const inputs = predictInputs(scenario, changes);
  const all = scenario.places.drives.map((drive) => mostOf(scenario, drive, inputs));
  return scenario.places.drives.map((drive, k): Source => {
    const most = all[k]! || Math.max(...all) || 1;
    if (scenario.layout.march !== "given") return { drive, kind: "heat", strength: most, most: ROOM * most, share: 0 };
    return { drive, kind: /^reference\b/.test(drive.name) ? "setpoint" : "document", strength: BEGUN * most, most, share: 0 };
  });
}

/** Level of a drive now; none (NaN) of a signal of the document. */
const levelOf = ({ kind, strength, share }: Source): number => (kind === "heat" ? strength * share : kind === "setpoint" ? strength : NaN);

export const changesOf = ({ model, load }: Hand): Changes => (load && moved ? { ...model.changes, [load.path]: load.value } : model.changes);

function parametersOf(now: Hand): Record<string, number> {
  const { scenario } = now.model;
  const inputs = predictInputs(scenario, changesOf(now));
  return Object.fromEntries(scenario.parameters.map((path, k) => [path, inputs[k]!]));
}

let parameters: Record<string, number> = {};

/** Begin, or go on from what was recorded and is still shown. */
export async function beginLive(): Promise<void> {
  if (hand.value || preparing.value || !run.value) return;
  pause();
  said.value = "";
  if (begun.hand && begun.run === run.value) return takeUp(begun.hand, begun.run);
  const first = run.value;
  preparing.value = true;
  try {
    const model = await findModel(text.value);
    await renewWorker();
    const found = await ask({ begin: { from: model.from, scenario: model.scenario }, changes: model.changes });
    if ("refused" in found) throw new Error(found.refused);
    if (run.value !== first) return; // something else was run meanwhile
    moved = false;
    takeUp({ model, recording: new Recording(model.scenario, first), drives: listDrives(model), load: findLoad(model.scenario, model.text, model.changes) }, first);
  } catch (error) {
    said.value = sentence(error);
  } finally {
    preparing.value = false;
  }
}

function takeUp(now: Hand, first: Run): void {
  parameters = parametersOf(now);
  begun.hand = null;
  batch(() => {
    before.value = now.recording.before;
    shown = first;
    hand.value = now;
  });
  clock = performance.now();
  frame = requestAnimationFrame(tick);
}

/** The clock went on: the model follows, if it is not still at the step before, as often as the mechanism is drawn. */
function tick(): void {
  const stamp = performance.now();
  frame = hand.peek() ? requestAnimationFrame(tick) : 0;
  const now = hand.peek();
  if (!now || busy || stamp - clock < (shownStage.current?.interval ?? 0)) return;
  const seconds = Math.min(Math.max((stamp - clock) / 1000, 0), LONGEST);
  clock = stamp;
  if (seconds > 0) void step(now, seconds);
}

async function step(now: Hand, seconds: number): Promise<void> {
  busy = true;
  pull(now, seconds);
  const { recording, model, load } = now;
  const length = seconds * (inRealTime.peek() ? 1 : rate());
  const parts = Math.min(Math.max(Math.ceil((length * FINE) / model.duration), 1), MOST_PARTS);
  const levels = now.drives.map(levelOf);
  const value = load?.value;
  const changes = changed ? changesOf(now) : null;
  changed = false;
  const found = await ask({ length, parts, levels, changes });
  busy = false;
  if (hand.peek() !== now) return;
  if ("refused" in found || found.said) return refuse(now, "refused" in found ? found.refused : found.said, "refused" in found);
  good = value;
  if (changes) parameters = parametersOf(now);
  recording.add({ times: found.times, rows: found.rows, levels, seconds: found.took / 1000 });
  draw(now);
  for (const watch of watchers) watch(now);
}

/** The load with which the model went on last. */
let good: number | undefined;

/** What cannot go on so: the heat is off, and the load as it was. */
function refuse(now: Hand, words: string, over: boolean): void {
  said.value = over ? words : `${words} It is let go.`;
  spoken = performance.now();
  now.drives.forEach((one) => (one.share = 0));
  if (now.load && good !== undefined && good !== now.load.value) {
    now.load.value = good;
    changed = true;
  }
  turned.value++;
  if (over) stopLive();
}

function draw(now: Hand): void {
  const begin = performance.now();
  if (calm() && begin - drawn < CALM) return;
  drawn = begin;
  const next = now.recording.draw(parameters);
  batch(() => {
    if (said.peek() && begin - spoken > STANDS) said.value = "";
    shown = next;
    run.value = next;
    cursor.value = now.recording.end;
  });
}

const HAND = "Recorded by hand";

/** Stop, and keep what was recorded as the run that is shown. */
export function stopLive(): void {
  const now = hand.peek();
  if (!now) return;
  leave();
  const { recording, model } = now;
  if (recording.times.length < 3) return void (run.value = before.value);
  const path = (name: string): string => {
    const port = model.scenario.places.drives.find((one) => one.name === name)?.port;
    return !port ? "" : model.scenario.views.elements.prefixed ? `actuators.${port}.drive.waveform` : "drive.waveform";
  };
  const load = now.load && moved ? { [now.load.path]: `${now.load.value} ${now.load.unit}`.trim() } : {};
  const written = recording.write(model.text, load, path);
  const why = written === null ? "its drives do not fit into a document" : moved ? `the ${now.load!.words.toLowerCase()} was changed while it ran, and the document has its last value` : "";
  const caution = why ? `${HAND}: ${why}. A reload does not bring this run back: save its numbers.` : "";
  const kept = recording.keep(written ?? model.text, parameters, caution ? [caution] : []);
  Object.assign(begun, { run: kept, hand: now });
  batch(() => {
    before.value = null;
    run.value = why ? { ...kept, only: true } : kept;
    cursor.value = recording.end;
  });
  begun.run = run.value;
}

/** Nothing runs by hand any more; what is shown stays. */
function leave(): void {
  cancelAnimationFrame(frame);
  batch(() => {
    hand.value?.drives.forEach((one) => (one.share = 0));
    hand.value = null;
    before.value = null;
  });
  held = null;
}

// another run came, of a control that was moved: it is what counts
effect(() => {
  const now = run.value;
  if (hand.peek() && now !== shown) leave();
});

// ---------------------------------------------------------------- what is held

/** Give a share of a drive's strength. */
export function giveShare(k: number, share: number): void {
  const one = hand.peek()?.drives[k];
  if (!one || one.kind !== "heat" || one.share === share) return;
  one.share = share;
  turned.value++;
}

export function setStrength(k: number, strength: number): void {
  const one = hand.peek()?.drives[k];
  if (!one) return;
  one.strength = strength;
  turned.value++;
}

export function setLoad(value: number): void {
  const load = hand.peek()?.load;
  if (!load) return;
  load.value = clampLoad(load, value);
  changed = moved = true;
  turned.value++;
}

/** Dragging of a body in space. */
export const grabbing = {
  from: 0,
  at: [0, 0, 0] as readonly [number, number, number],
  may: (name: string): boolean => {
    const now = hand.peek();
    const shape = run.peek()?.scene.shapes.find((one) => one.name === name);
    return !!now?.load && !!shape && now.load.shapes.includes(shape.kind);
  },
  onGrab(_: string, point: [number, number, number]): void {
    this.from = hand.peek()?.load?.value ?? 0;
    this.at = point;
  },
  onDrag(_: string, point: [number, number, number]): void {
    const load = hand.peek()?.load;
    const scene = run.peek()?.scene;
    if (!load || !scene) return;
    const extent = Math.hypot(...scene.high.map((x, k) => x - scene.low[k]!)) || 1;
    setLoad(dragLoad(load, this.from, point.map((x, k) => x - this.at[k]!) as [number, number, number], extent));
  },
  onRelease: (): void => undefined,
};

// ---------------------------------------------------------------- the point in the phase diagram

/** The pointer that pulls at a point of a diagram, and where that point is; in pixels. */
interface Pull {
  dot: Element;
  /** Number of the drive; none below 0. */
  drive: number;
  x: number;
  y: number;
}

let held: Pull | null = null;
/** As far right of the point as this, the heat is full [px]; so far up, the load goes through its range in a second. */
const FAR = 30;
const HIGH = 240;

export const pullAt = (pull: Pull | null): void => {
  if (!pull && held) giveShare(held.drive, 0);
  held = pull;
};

/** The pointer draws the point as by a rubber band: heat by how far it is to the right, load by how far it is above. */
function pull(now: Hand, seconds: number): void {
  if (!held) return;
  const box = held.dot.getBoundingClientRect();
  const right = held.x - (box.left + box.width / 2);
  const above = box.top + box.height / 2 - held.y;
  giveShare(held.drive, Math.min(Math.max(right / FAR, 0), 1));
  const { load } = now;
  if (load && Math.abs(above) > 3) setLoad(load.value + (load.loads * above * seconds * (load.high - load.low)) / HIGH);
}
