// The run of the scenario on the bench, those that are pinned beside it, and the time cursor.

import { batch, computed, effect, signal } from "@preact/signals";
import { expectChanges, runServed } from "../engine/served.ts";
import { call, cancelCall, sentence, superseded } from "../lib/api.ts";
import type { Run } from "../lib/types.ts";
import { change, text } from "./scenario.ts";
import { keepPart } from "./session.ts";

export const run = signal<Run | null>(null);
/** The sentence of what was refused last; empty if the curves show the document. */
export const refused = signal("");
export const computing = signal(false);

/** While a model runs by hand: the run from which that began, which stays in the picture. */
export const before = signal<Run | null>(null);

/** Time of the cursor [s]. */
export const cursor = signal(0);

export interface Pinned {
  id: number;
  name: string;
  run: Run;
}

export const pinned = signal<Pinned[]>([]);
let pins = 0;

/** A pinned run that has to be computed anew, after a reload or from a link. */
export interface Waiting {
  id: number;
  name: string;
  text: string;
  /** Why it cannot be computed; empty if it was not tried yet. */
  trouble: string;
  /** Whether no document tells how it came about. */
  only?: boolean;
}

const ONLY_THERE = "This run was recorded by hand with more changes than a scenario can store, so it was lost when the page closed.";

export const waiting = signal<Waiting[]>([]);

const isWaiting = (one: Partial<Waiting> | null): one is Waiting =>
  typeof one?.id === "number" && typeof one.name === "string" && typeof one.text === "string";

keepPart(
  "runs",
  () => {
    const all = [...pinned.value.map(({ id, name, run: { text, only } }) => ({ id, name, text, ...(only ? { only } : {}) })), ...waiting.value.map(({ id, name, text, only }) => ({ id, name, text, ...(only ? { only } : {}) }))];
    return { cursor: cursor.value, count: pins, pins: all.sort((a, b) => a.id - b.id) };
  },
  (kept) => {
    const found = kept as { cursor?: unknown; count?: unknown; pins?: Partial<Waiting>[] };
    batch(() => {
      if (typeof found.cursor === "number" && found.cursor >= 0) cursor.value = found.cursor;
      if (typeof found.count === "number") pins = found.count;
      if (!Array.isArray(found.pins)) return;
      waiting.value = found.pins.filter(isWaiting).map((one) => ({ ...one, trouble: one.only ? ONLY_THERE : "" }));
      pinned.value = [];
      pins = Math.max(pins, 0, ...waiting.value.map((one) => one.id));
    });
  },
);

/** Compute pinned runs that wait, one after the other, once the run on the bench is there. */
export function followWaiting(): () => void {
  let busy = false;
  return effect(() => {
    const next = waiting.value.find((one) => !one.trouble);
    if (!run.value || !next || busy) return;
    busy = true;
    call<Run>("run", { text: next.text, changes: {} })
      .then(
        (found) => settle(next.id, { id: next.id, name: next.name, run: found }),
        (error: unknown) => (waiting.value = waiting.value.map((one) => (one.id === next.id ? { ...one, trouble: sentence(error) } : one))),
      )
      .finally(() => {
        busy = false;
        waiting.value = [...waiting.value]; // the next one
      });
  });
}

/** A run that waited is there, unless it was unpinned meanwhile. */
function settle(id: number, made: Pinned): void {
  if (!waiting.value.some((one) => one.id === id)) return;
  batch(() => {
    waiting.value = waiting.value.filter((one) => one.id !== id);
    pinned.value = [...pinned.value, made].sort((a, b) => a.id - b.id);
  });
}

/** Row of the run's samples at the time of the cursor. */
export const row = computed(() => {
  const times = run.value?.times ?? [];
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) < cursor.value) low = middle + 1;
    else high = middle;
  }
  return low;
});

/** Numbers that are being changed, in the order in which they come: only the newest is run. */
let latest = 0;
/** The text that `run` shows, or tries to. */
let shown = "";

/** Run a document with changes; it becomes the state if it can be run, of which `taken` is told before. */
export async function tryChanges(changes: Record<string, unknown>, merge = false, taken: (document: string) => void = () => undefined): Promise<boolean> {
  return show(text.value, changes, merge, taken);
}

async function show(document: string, changes: Record<string, unknown>, merge: boolean, taken: (document: string) => void = () => undefined): Promise<boolean> {
  const mine = ++latest;
  computing.value = true;
  try {
    const own = runServed(document, changes);
    const found = await (own ?? call<Run>("run", { text: document, changes }, "run"));
    if (mine !== latest) return false;
    if (!own) void expectChanges(found.text, Object.keys(changes));
    taken(found.text);
    batch(() => {
      shown = found.text;
      change(found.text, merge);
      run.value = found;
      refused.value = "";
      const end = found.times.at(-1) ?? 0;
      if (cursor.value > end) cursor.value = end;
    });
    return true;
  } catch (error) {
    if (mine === latest && !superseded(error)) refused.value = sentence(error);
    return false;
  } finally {
    if (mine === latest) computing.value = false;
  }
}

/** End the run that is being made; the one before stays. */
export const cancelRun = (): void => void cancelCall("run").catch(() => undefined);

/** Run whatever document comes into place otherwise: loaded, undone, redone. */
export function followDocument(): () => void {
  return effect(() => {
    const now = text.value;
    if (now && now !== shown) {
      shown = now;
      void show(now, {}, true);
    }
  });
}

export function pin(): void {
  if (!run.value) return;
  pins += 1;
  pinned.value = [...pinned.value, { id: pins, name: `${pins}: ${run.value.title}`, run: run.value }];
}

export function unpin(id: number): void {
  pinned.value = pinned.value.filter((one) => one.id !== id);
  waiting.value = waiting.value.filter((one) => one.id !== id);
}
