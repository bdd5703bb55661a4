// Searches for changes that bring the run on the bench below its limits.

import { computed, signal } from "@preact/signals";
import { form } from "../form/state.ts";
import { call, superseded } from "../lib/api.ts";
import type { Run } from "../lib/types.ts";
import { run } from "../state/run.ts";
import { dangersOf, findCure, knobsOf, type Cure } from "../views/cures.ts";
import { entriesOf } from "../views/remedies.ts";
import { followRuns } from "./trials.ts";

const MOST_CURES = 3;

/** Exceeded limits of the run that is shown. */
export const dangers = computed(() => (run.value ? dangersOf(run.value) : []));

export const cures = signal<Cure[]>([]);
/** State of the search for the run that is shown. */
export const search = signal<"waiting" | "running" | "done">("waiting");

/** Find cures of the first danger with runs; stops if another run comes. */
export async function searchCures(): Promise<void> {
  const [before, alarm, entries] = [run.peek(), dangers.peek()[0], form.peek()];
  if (!before || !alarm || entries?.text !== before.text || search.peek() !== "waiting") return;
  search.value = "running";
  const ask = (changes: Record<string, unknown>): Promise<Run> => call<Run>("run", { text: before.text, changes }, "remedy");
  for (const knob of knobsOf(entriesOf(entries.sections), alarm.kind)) {
    if (cures.peek().length >= MOST_CURES) break;
    const found = await findCure(knob, alarm, before, ask).catch((error: unknown) => (superseded(error) ? undefined : null));
    if (run.peek() !== before) return;
    if (found) cures.value = [...cures.peek(), found];
  }
  search.value = "done";
}

/** Search by itself once the reader pauses; returns the function that ends this. */
export const followCures = (): (() => void) =>
  followRuns(
    () => {
      cures.value = [];
      search.value = "waiting";
    },
    (now) => dangers.value.length > 0 && search.value === "waiting" && form.value?.text === now.text,
    searchCures,
  );
