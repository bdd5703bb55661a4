// The scenario on the bench: its text is the whole state. Every change is one step to undo.

import { batch, computed, effect, signal } from "@preact/signals";
import { packed, unpacked } from "../lib/pack.ts";
import { go, place, remember } from "./route.ts";

const MOST_STEPS = 200;

/** The document, TOML. Empty until one is loaded. */
export const text = signal("");
const before = signal<string[]>([]);
const after = signal<string[]>([]);

export const canUndo = computed(() => before.value.length > 0);
export const canRedo = computed(() => after.value.length > 0);

/** Put another document in place; `merge` takes it as part of the last change, as of a slider. */
export function change(next: string, merge = false): void {
  if (next === text.value) return;
  batch(() => {
    if (!merge && text.value) before.value = [...before.value, text.value].slice(-MOST_STEPS);
    after.value = [];
    text.value = next;
  });
}

export function undo(): void {
  const last = before.value.at(-1);
  if (last === undefined) return;
  batch(() => {
    after.value = [...after.value, text.value];
    before.value = before.value.slice(0, -1);
    text.value = last;
  });
}

export function redo(): void {
  const next = after.value.at(-1);
  if (next === undefined) return;
  batch(() => {
    before.value = [...before.value, text.value];
    after.value = after.value.slice(0, -1);
    text.value = next;
  });
}

/** Take the scenario from the address, if one is there. */
export async function fromAddress(): Promise<boolean> {
  const letters = place.value.query.get("scenario");
  if (!letters) return false;
  try {
    change(await unpacked(letters));
    return true;
  } catch {
    return false;
  }
}

let waiting = 0;

/** Keep the address in step with the document. */
export function followInAddress(): () => void {
  return effect(() => {
    const now = text.value;
    if (!now || place.value.page !== "bench") return;
    clearTimeout(waiting);
    waiting = window.setTimeout(async () => {
      const letters = await packed(now);
      if (text.value === now) remember("bench", { scenario: letters });
    }, 300);
  });
}

/** Put a scenario on the bench and go there. */
export function openInBench(document: string): void {
  change(document);
  go("bench");
}
