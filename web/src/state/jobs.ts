// Long work of this tab: begun, watched, found again after a reload, cancelled.

import { signal, type Signal } from "@preact/signals";
import { beginJob, cancelJob, type Job, jobs, sentence, watchJob } from "../lib/api.ts";
import { awaitServer } from "../lib/connection.ts";
import { keepPart } from "./session.ts";

export interface Watched<Note, Outcome> {
  job: Signal<Job<Note, Outcome> | null>;
  /** Sentence of what went wrong with starting or watching; empty if nothing did. */
  trouble: Signal<string>;
  begin: (request: object) => Promise<void>;
  /** End it, by force where it does not end by itself in time; `patient`: it may take some seconds to keep what it has. */
  cancel: (patient?: boolean) => Promise<void>;
  /** Take up the newest job of this call that the tab has, as after a reload. */
  resume: () => Promise<void>;
}

const AGAIN = 1000;
/** Seconds in which cancelled work may end by itself. */
const GRACE = 0.6;
/** The longest job that is kept with the session [characters of JSON]. */
const MOST_KEPT = 2 ** 20;
const ENDED = "The server stopped before the end. Start again.";

/** Newest job of every kind, so far as it is known. */
const known = signal<Record<string, Job>>({});
const takers = new Map<string, (job: Job) => void>();

keepPart(
  "jobs",
  () => known.value,
  (kept) => {
    known.value = kept as Record<string, Job>;
    for (const [name, job] of Object.entries(known.value)) takers.get(name)?.(job);
  },
);

function remember(name: string, job: Job | null): void {
  const { [name]: _, ...others } = known.peek();
  const short = job && { ...job, trail: job.trail.slice(0, 1) };
  known.value = job && JSON.stringify(job).length <= MOST_KEPT ? { ...others, [name]: job } : short && JSON.stringify(short).length <= MOST_KEPT ? { ...others, [name]: short } : others;
}

/** Whether nothing more will be heard of a job; one that a session kept may still run. */
export const isOver = (job: { state: string } | null): boolean => job !== null && job.state !== "running";

/** One kind of long work, by the name of its call. */
export function watched<Note, Outcome>(name: string): Watched<Note, Outcome> {
  const job = signal<Job<Note, Outcome> | null>(null);
  const trouble = signal("");
  let leave = (): void => {};

  const take = (found: Job): void => void (job.value ??= found as Job<Note, Outcome>);
  takers.set(name, take);
  const before = known.peek()[name];
  if (before) take(before);

  function follow(id: string, tries = 5): void {
    leave();
    leave = watchJob<Note, Outcome>(
      id,
      (message) => {
        trouble.value = "";
        if (message.job) {
          job.value = message.job;
          remember(name, message.job as Job);
        }
        const now = job.value;
        if (message.note && now) job.value = { ...now, last: message.note, trail: [...now.trail, message.note] };
      },
      (reason, gone) => {
        if (gone) return end();
        trouble.value = reason;
        if (tries > 0) setTimeout(() => void awaitServer().then(() => follow(id, tries - 1)), AGAIN);
      },
    );
  }

  /** The server does not have it any more: what was done is known, what was not is lost. */
  function end(): void {
    trouble.value = "";
    const now = job.value;
    if (now?.state !== "running") return;
    job.value = { ...now, state: "failed", outcome: ENDED };
    remember(name, job.value as Job);
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
    cancel: (patient = false) => attempt(async () => void (job.value && (await cancelJob(job.value.id, patient ? undefined : GRACE)))),
    resume: () =>
      attempt(async () => {
        const [found] = await jobs(name);
        if (found) follow(found.id);
        else end();
      }),
  };
}
