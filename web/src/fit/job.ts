// Fits of this page as jobs, begun, watched and ended as those of the server are.

import type { Note, Outcome } from "../identify/types.ts";
import type { Job, JobSummary } from "../lib/api.ts";
import { makeId } from "../lib/tab.ts";
import type { Descent } from "./descent.ts";
import type { Curves } from "./problem.ts";
import { toValue } from "./problem.ts";
import { describeNote, describeOutcome, describeProblem, INTERRUPTED, type Task } from "./outcome.ts";
import { arrangeFit, type FitRequest } from "./task.ts";
import type { AskedFit, ToldFit } from "./worker.ts";

type FitJob = Job<Note & Record<string, unknown>, Outcome>;
type Heard = (message: { job?: FitJob; note?: Note }) => void;

interface Running {
  job: FitJob;
  listeners: Set<Heard>;
  worker: Worker | null;
  task: Task | null;
  /** The best so far, and how far runs are off. */
  last: { now: Descent<Curves>; apart: number } | null;
}

const known = new Map<string, Running>();

export function beginFit(request: object): JobSummary {
  const id = makeId();
  const job: FitJob = { id, call: "fit", state: "running", began: Date.now() / 1000, ended: null, last: null, request: request as Record<string, unknown>, trail: [], outcome: null };
  const running: Running = { job, listeners: new Set(), worker: null, task: null, last: null };
  known.set(id, running);
  beginSearch(running, request as FitRequest & { state?: string }).catch((error: unknown) => endJob(running, "failed", error instanceof Error ? error.message : String(error)));
  return job;
}

export function watchFit(id: string, heard: Heard): () => void {
  const running = known.get(id);
  running?.listeners.add(heard);
  if (running) heard({ job: { ...running.job } });
  return () => void running?.listeners.delete(heard);
}

export const listFits = (): JobSummary[] => [...known.values()].reverse().map(({ job }) => job);

/** End a search at once; the best so far is its outcome. */
export function cancelFit(id: string): JobSummary {
  const running = known.get(id)!;
  if (running.job.state === "running") finishJob(running);
  return running.job;
}

async function beginSearch(running: Running, request: FitRequest & { state?: string }): Promise<void> {
  const task = await arrangeFit(request);
  resumeSearch(task, request.state);
  if (running.job.state !== "running") return;
  running.task = task;
  addNote(running, { problem: describeProblem(task, running.job.id) });
  const worker = (running.worker = new Worker(new URL("fit.js", document.baseURI), { type: "module" }));
  const { scenario, address } = task.followed;
  worker.onmessage = ({ data }: MessageEvent<ToldFit>) => {
    if ("refused" in data) return endJob(running, "failed", data.refused);
    running.last = data;
    addNote(running, describeNote(task, data.now, countSeconds(running)));
    if (data.now.reason) finishJob(running);
  };
  worker.onerror = () => endJob(running, "failed", "The calculation ended unexpectedly; try again.");
  worker.postMessage({ address, scenario, problem: task.problem } satisfies AskedFit);
}

/** Go on from where an earlier search of this page was. */
function resumeSearch(task: Task, state: string | undefined): void {
  const before = state ? known.get(state) : undefined;
  if (!before?.last || !before.task) return;
  before.task.free.forEach((free, k) => {
    const own = task.free.findIndex((one) => one.path === free.path);
    if (own < 0) return;
    const value = toValue(free, before.last!.now.shares[k]!);
    task.free[own]!.start = task.problem.free[own]!.start = Math.min(task.free[own]!.high, Math.max(task.free[own]!.low, value));
  });
}

const countSeconds = ({ job }: Running): number => Date.now() / 1000 - job.began;

function addNote(running: Running, found: Note): void {
  const one = { ...found };
  running.job.trail.push(one);
  running.job.last = one;
  running.listeners.forEach((heard) => heard({ note: one }));
}

function finishJob(running: Running): void {
  const { task, last } = running;
  if (!task || !last) return endJob(running, "failed", "The fit was stopped before its first run had ended.");
  const now = last.now.reason ? last.now : { ...last.now, reason: INTERRUPTED };
  endJob(running, "done", describeOutcome(task, now, last.apart, countSeconds(running), running.job.id));
}

function endJob(running: Running, state: FitJob["state"], outcome: FitJob["outcome"]): void {
  running.worker?.terminate();
  running.worker = null;
  Object.assign(running.job, { state, outcome, ended: Date.now() / 1000 });
  running.listeners.forEach((heard) => heard({ job: { ...running.job } }));
}
