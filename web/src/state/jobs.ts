// Long work of this tab: begun, watched, found again after a reload, cancelled.

import { signal, type Signal } from "@preact/signals";
import { beginJob, cancelJob, type Job, jobs, sentence, watchJob } from "../lib/api.ts";

export interface Watched<Note, Outcome> {
  job: Signal<Job<Note, Outcome> | null>;
  /** Sentence of what went wrong with starting or watching; empty if nothing did. */
  trouble: Signal<string>;
  begin: (request: object) => Promise<void>;
  cancel: () => Promise<void>;
  /** Take up the newest job of this call that the tab has, as after a reload. */
  resume: () => Promise<void>;
}

const AGAIN = 1000;

/** One kind of long work, by the name of its call. */
export function watched<Note, Outcome>(name: string): Watched<Note, Outcome> {
  const job = signal<Job<Note, Outcome> | null>(null);
  const trouble = signal("");
  let leave = (): void => {};

  function follow(id: string, tries = 5): void {
    leave();
    leave = watchJob<Note, Outcome>(
      id,
      (message) => {
        trouble.value = "";
        if (message.job) job.value = message.job;
        const now = job.value;
        if (message.note && now) job.value = { ...now, last: message.note, trail: [...now.trail, message.note] };
      },
      (reason) => {
        trouble.value = reason;
        if (tries > 0) setTimeout(() => follow(id, tries - 1), AGAIN);
      },
    );
  }

  const attempt = async (action: () => Promise<void>): Promise<void> => {
    try {
      trouble.value = "";
      await action();
    } catch (error) {
      trouble.value = sentence(error);
    }
  };

  return {
    job,
    trouble,
    begin: (request) => attempt(async () => follow((await beginJob(name, request)).id)),
    cancel: () => attempt(async () => void (job.value && (await cancelJob(job.value.id)))),
    resume: () =>
      attempt(async () => {
        const found = (await jobs()).find((one) => one.call === name);
        if (found) follow(found.id);
      }),
  };
}
