// Keeps what is shown in step with the job of this tab and with the address.

import { computed, effect } from "@preact/signals";
import { go } from "../state/route.ts";
import { key, list, load, runs, stored, takeNotes, work } from "./shown.ts";
import type { Note } from "./types.ts";

const jobKey = computed(() => work.job.value?.trail.find((note) => note.key)?.key ?? "");
/** Whether the job of this tab makes the sweep that is shown. */
export const live = computed(() => jobKey.value !== "" && jobKey.value === key.value);
export const running = computed(() => work.job.value?.state === "running");
export const keyOfJob = jobKey;

export function follow(): () => void {
  let seen = 0;
  let of = "";
  let opened = "";
  let ended = "";

  /** Notes of the shown sweep that have not been taken; a gap in their numbers lets all be loaded. */
  function hear(id: string, trail: Note[]): void {
    if (id !== of) [of, seen] = [id, 0];
    const fresh = trail.filter((note) => note.number > seen);
    const first = fresh[0];
    if (!first) return;
    const gap = seen > 0 && fresh.some((note, k) => note.number !== seen + 1 + k);
    seen = fresh.at(-1)?.number ?? seen;
    if (key.peek() !== jobKey.peek()) return;
    if (gap) void load(key.peek());
    else takeNotes(fresh);
  }

  const leave = [
    effect(() => {
      const wanted = key.value;
      if (wanted) void load(wanted);
      else [stored.value, runs.value] = [null, null];
    }),
    effect(() => {
      const job = work.job.value;
      if (!job) return;
      const found = jobKey.value;
      if (found && opened !== job.id) {
        opened = job.id;
        if (!key.peek()) go(`sweep/${found}`);
        void list();
      }
      hear(job.id, job.trail);
      if (job.state !== "running" && ended !== job.id) {
        ended = job.id;
        if (found && found === key.peek()) void load(found);
        void list();
      }
    }),
  ];
  return () => leave.forEach((end) => end());
}
