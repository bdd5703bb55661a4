// Runs beside the one on the bench that tell what a remedy brings: the likeliest by itself, others when asked for.

import { computed, effect, signal } from "@preact/signals";
import { form } from "../form/state.ts";
import { call, superseded } from "../lib/api.ts";
import type { Run } from "../lib/types.ts";
import { computing, run } from "../state/run.ts";
import { text } from "../state/scenario.ts";
import { gainOf, insightOf, writePromise } from "../views/insight.ts";
import { entriesOf, remediesOf, type Changes, type Remedy } from "../views/remedies.ts";
import { dangersOf } from "../views/cures.ts";
import { cycleOf, peakOf, findTracked, startOf } from "../views/results.ts";

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
export const CALM = 700;
/** A controlled run that takes longer is not tried again without being asked for [s]; others are compiled by then. */
const QUICK = 1;
export const isQuick = (now: Run): boolean => now.seconds < QUICK || !findTracked(now);
/** So many remedies are tried without being asked for. */
const FEW = 2;
/** How near to the old peak temperature a trial comes, as a share of the rise, and in how many runs. */
const [NEAR, MOST] = [0.02, 4];

export const insight = computed(() => (run.value ? insightOf(run.value) : null));

/** Remedies for the run that is shown; none while its form is on the way or a limit is exceeded. */
export const remedies = computed<Remedy[]>(() => {
  const [now, entries, said] = [run.value, form.value, insight.value];
  if (!now || !said?.aim || entries?.text !== now.text || dangersOf(now).length) return [];
  return remediesOf(entriesOf(entries.sections), said.aim, cycleOf(now)?.off ?? null);
});

/** How much hotter than its surroundings a wire gets [K]. */
const rise = (of: Run): number => (peakOf(of, "hottest") ?? 0) - startOf(of, "temperature");

/** Shares of the heat that were found, by remedy: the next run begins with them. */
const found = new Map<string, number>();

async function tried(remedy: Remedy, before: Run): Promise<Trial> {
  let share = remedy.share === null ? 1 : (found.get(remedy.key) ?? remedy.share);
  for (let k = 1; ; k++) {
    const changes = remedy.changes(share);
    const after = await call<Run>("run", { text: before.text, changes }, "remedy");
    const ratio = rise(before) / rise(after);
    if (remedy.share === null || !Number.isFinite(ratio)) return { remedy, run: after, changes };
    if (Math.abs(ratio - 1) < NEAR || k === MOST) {
      found.set(remedy.key, share);
      return { remedy, run: after, changes };
    }
    share *= ratio;
  }
}

/** Trials that help, the largest effect first, and the others. */
export const sorted = computed(() => {
  const [now, aim] = [run.value, insight.value?.aim];
  if (!now || !aim) return { helpful: [], others: [] };
  const gain = (trial: Trial): number => (trial.run ? gainOf(now, trial.run, aim) : 0);
  const helpful = trials.value.filter((one) => gain(one) > 0).sort((a, b) => gain(b) - gain(a));
  return { helpful, others: trials.value.filter((one) => !helpful.includes(one)) };
});

/** What the first trial that brings something gave, in a sentence; empty if none did. */
export const promised = computed(() => {
  const [now, aim] = [run.value, insight.value?.aim];
  if (!now || !aim) return "";
  for (const { remedy, run: after } of trials.value) {
    const said = after && gainOf(now, after, aim) > 0 && writePromise(now, after, aim, remedy.words, remedy.wires);
    if (said) return said;
  }
  return "";
});

/** Try remedies that were not tried yet: all, or until one brings something. */
export async function tryRemedies(isAll: boolean): Promise<void> {
  const before = run.peek();
  if (!before || trying.peek()) return;
  const left = (): Remedy | undefined => remedies.peek().find((one, k) => (isAll || k < FEW) && !trials.peek().some((trial) => trial.remedy.key === one.key));
  const open = (): Remedy | undefined => (isAll || !promised.peek() ? left() : undefined);
  trying.value = true;
  try {
    for (let remedy = open(); remedy && run.peek() === before; remedy = open()) {
      const changes = remedy.changes(remedy.share ?? 1);
      const one = remedy;
      const trial = await tried(one, before).catch((error: unknown) => (superseded(error) ? null : { remedy: one, run: null, changes }));
      if (!trial || run.peek() !== before) return;
      trials.value = [...trials.peek(), trial];
    }
  } finally {
    trying.value = false;
  }
}

/** Start something for each quick run once the reader pauses; returns the function that ends this. */
export function followRuns(reset: () => void, isReady: (now: Run) => boolean, start: () => Promise<void>): () => void {
  let waiting = 0;
  let shown: Run | null = null;
  return effect(() => {
    const now = run.value;
    if (now !== shown) {
      shown = now;
      reset();
    }
    clearTimeout(waiting);
    const isCalm = !computing.value && text.value === now?.text;
    if (now && isCalm && isReady(now) && isQuick(now)) waiting = window.setTimeout(() => void start(), CALM);
  });
}

/** Keep the first trial in step with the run; returns the function that ends this. */
export const followTrials = (): (() => void) =>
  followRuns(
    () => {
      trials.value = [];
    },
    () => remedies.value.length > 0 && trials.value.length === 0 && !trying.value,
    () => tryRemedies(false),
  );
