// The run of the scenario on the bench, those that are pinned beside it, and the time cursor.

import { batch, computed, effect, signal } from "@preact/signals";
import { call, sentence, superseded } from "../lib/api.ts";
import type { Run } from "../lib/types.ts";
import { change, text } from "./scenario.ts";

export const run = signal<Run | null>(null);
/** The sentence of what was refused last; empty if the curves show the document. */
export const refused = signal("");
export const computing = signal(false);

/** Time of the cursor [s]. */
export const cursor = signal(0);

export interface Pinned {
  id: number;
  name: string;
  run: Run;
}

export const pinned = signal<Pinned[]>([]);
let pins = 0;

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

/** Run a document with changes; it becomes the state if it can be run. */
export async function tryChanges(changes: Record<string, unknown>, merge = false): Promise<boolean> {
  return show(text.value, changes, merge);
}

async function show(document: string, changes: Record<string, unknown>, merge: boolean): Promise<boolean> {
  const mine = ++latest;
  computing.value = true;
  try {
    const found = await call<Run>("run", { text: document, changes }, "run");
    if (mine !== latest) return false;
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

export const unpin = (id: number): void => void (pinned.value = pinned.value.filter((one) => one.id !== id));
