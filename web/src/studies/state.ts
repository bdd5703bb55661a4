// The study that is shown, and the one that is being computed: one at a time in a tab.

import { computed, effect, signal } from "@preact/signals";
import { call, sentence, superseded } from "../lib/api.ts";
import { watched } from "../state/jobs.ts";
import type { Claim, Listed, Note, Results, StudyPage } from "./types.ts";

export const work = watched<Note, Results>("study");
export const listed = signal<Listed[] | null>(null);
export const shown = signal<StudyPage | null>(null);
/** Sentence of what could not be loaded. */
export const trouble = signal("");
export const cancelling = signal(false);

export const running = computed(() => work.job.value?.state === "running");
/** Name of the study that the newest job is about. */
export const subject = computed(() => String(work.job.value?.request["name"] ?? ""));
/** Claims of the parts that are over. */
export const soFar = computed<Claim[]>(() => (work.job.value?.trail ?? []).flatMap((note) => note.claims));

async function loaded<T>(name: string, request: object, put: (found: T) => void): Promise<void> {
  try {
    trouble.value = "";
    put(await call<T>(name, request, "studies"));
  } catch (error) {
    if (!superseded(error)) trouble.value = sentence(error);
  }
}

export const list = (): Promise<void> => loaded<{ studies: Listed[] }>("studies", {}, (found) => (listed.value = found.studies));

export async function open(name: string): Promise<void> {
  if (shown.value?.name !== name) shown.value = null;
  await loaded<StudyPage>("study_page", { name }, (found) => (shown.value = found));
}

export async function begin(name: string): Promise<void> {
  cancelling.value = false;
  await work.begin({ name });
}

export async function cancel(): Promise<void> {
  cancelling.value = true;
  await work.cancel();
  cancelling.value = false;
}

let taken = "";

/** Show what a finished job has found, once, if its study is the one that is open. */
export const follow = (): (() => void) =>
  effect(() => {
    const job = work.job.value;
    const page = shown.value;
    if (!job || job.state !== "done" || !page || job.id === taken || subject.value !== page.name) return;
    taken = job.id;
    if (job.outcome && typeof job.outcome === "object") shown.value = { ...page, results: job.outcome };
    void open(page.name); // data that were missing may have come
  });
