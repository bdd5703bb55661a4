// Runs beside the one on the bench that tell what a remedy brings: the likeliest by itself, others when asked for.

import { computed, effect, signal } from "@preact/signals";
import { form } from "../form/state.ts";
import { call, superseded } from "../lib/api.ts";
import type { Run } from "../lib/types.ts";
import { computing, run } from "../state/run.ts";
import { text } from "../state/scenario.ts";
import { insightOf } from "../views/insight.ts";
import { entriesOf, remediesOf, type Changes, type Remedy } from "../views/remedies.ts";
import { cycleOf, peakOf, tracked } from "../views/results.ts";

export interface Trial {
  remedy: Remedy;
  /** Null if it is refused. */
  run: Run | null;
  changes: Changes;
}

/** What is known of remedies for the run that is shown. */
export const trials = signal<Trial[]>([]);
export const trying = signal(false);

/** From the last change to the first trial [ms]; a slider in motion is not held up. */
const CALM = 700;
/** A controlled run that takes longer is not tried again without being asked for [s]; others are compiled by then. */
const QUICK = 1;
/** How near to the old peak temperature a trial comes, as a share of the rise, and in how many runs. */
const [NEAR, MOST] = [0.02, 4];

export const insight = computed(() => (run.value ? insightOf(run.value) : null));

/** Remedies for the run that is shown; none while its form is on the way. */
export const remedies = computed<Remedy[]>(() => {
  const [now, entries, said] = [run.value, form.value, insight.value];
  if (!now || !said?.aim || entries?.text !== now.text) return [];
  return remediesOf(entriesOf(entries.sections), said.aim, cycleOf(now)?.off ?? null);
});

/** How much hotter than its surroundings a wire gets [K]. */
const rise = (of: Run): number => (peakOf(of, "hottest") ?? 0) - (of.columns[of.ports.length > 1 ? `${of.ports[0]}.temperature` : "temperature"]?.[0] ?? 0);

async function tried(remedy: Remedy, before: Run): Promise<Trial> {
  let share = remedy.share ?? 1;
  for (let k = 1; ; k++) {
    const changes = remedy.changes(share);
    const found = await call<Run>("run", { text: before.text, changes }, "remedy");
    const ratio = rise(before) / rise(found);
    if (remedy.share === null || k === MOST || Math.abs(ratio - 1) < NEAR || !Number.isFinite(ratio)) return { remedy, run: found, changes };
    share *= ratio;
  }
}

/** Try remedies that were not tried yet, so many of them. */
export async function tryRemedies(most: number): Promise<void> {
  const before = run.peek();
  if (!before || trying.peek()) return;
  const open = (): Remedy | undefined => remedies.peek().slice(0, most).find((one) => !trials.peek().some((trial) => trial.remedy.key === one.key));
  trying.value = true;
  try {
    for (let remedy = open(); remedy && run.peek() === before; remedy = open()) {
      const changes = remedy.changes(remedy.share ?? 1);
      const found = await tried(remedy, before).catch((error: unknown) => (superseded(error) ? null : { remedy: remedy!, run: null, changes }));
      if (!found || run.peek() !== before) return;
      trials.value = [...trials.peek(), found];
    }
  } finally {
    trying.value = false;
  }
}

/** Keep the first trial in step with the run; returns what ends it. */
export function followTrials(): () => void {
  let waiting = 0;
  let shown: Run | null = null;
  return effect(() => {
    const now = run.value;
    if (now !== shown) {
      shown = now;
      trials.value = [];
    }
    clearTimeout(waiting);
    const isNew = remedies.value.length > 0 && trials.value.length === 0;
    const isCalm = !computing.value && !trying.value && text.value === now?.text;
    if (now && isNew && isCalm && (now.seconds < QUICK || !tracked(now))) waiting = window.setTimeout(() => void tryRemedies(1), CALM);
  });
}
