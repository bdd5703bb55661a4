// How far the running sweep is, and how it ended.

import { go } from "../state/route.ts";
import { Message } from "../ui/message.tsx";
import { Progress } from "../ui/progress.tsx";
import { keyOfJob, live, running } from "./following.ts";
import { key, stored, work } from "./shown.ts";
import { about, grouped } from "./time.ts";
import type { Note } from "./types.ts";

/** Runs by status in words: `ok` first. */
export function counted(counts: Record<string, number>): string {
  return Object.entries(counts)
    .map(([name, count]) => `${grouped(count)} ${name.replaceAll("_", " ")}`)
    .join(", ");
}

function words(note: Note | null): string {
  if (!note || note.phase === "preparing") return "Preparing the first runs …";
  const rate = note.rate ? `; ${note.rate < 10 ? note.rate.toFixed(1) : Math.round(note.rate)} runs/s` : "";
  const left = note.left ? `; ${about(note.left)} left` : "";
  return `${grouped(note.done ?? 0)} of ${grouped(note.runs ?? 0)} runs${rate}${left}`;
}

function Running() {
  const note = work.job.value?.last ?? null;
  const share = note?.runs ? (note.done ?? 0) / note.runs : null;
  const elsewhere = !live.value && keyOfJob.value;
  return (
    <div class="panel stack" aria-label="Running sweep" role="region">
      <Progress share={share} label={words(note)} onCancel={() => void work.cancel()} />
      {note?.counts && note.done ? <p class="soft small">Status: {counted(note.counts)}</p> : null}
      {note?.remarks?.map((remark) => (
        <Message key={remark} kind="caution">
          {remark}
        </Message>
      ))}
      {elsewhere && (
        <button type="button" onClick={() => go(`sweep/${keyOfJob.value}`)}>
          Show the running sweep
        </button>
      )}
    </div>
  );
}

function Ended() {
  const job = work.job.value;
  if (!job || job.state === "running") return null;
  if (typeof job.outcome === "string") {
    const kept = keyOfJob.value && keyOfJob.value === key.value ? " What was made is kept." : "";
    return <Message kind={job.state === "cancelled" ? "note" : "error"}>{`${job.outcome}${kept}`}</Message>;
  }
  const end = job.outcome;
  if (!end || (end.key ?? "") !== key.value) return null;
  if (end.stopped) return <Message kind="note">{end.stopped}</Message>;
  return (
    <>
      <Message kind="note">
        {grouped(end.done ?? 0)} runs are there{end.seconds ? `, after ${about(end.seconds)}` : ""}.
      </Message>
      {end.cautions?.map((caution) => (
        <Message key={caution} kind="caution">
          {caution}
        </Message>
      ))}
    </>
  );
}

/** A sweep that is shown and not whole can go on. */
function Stopped() {
  const now = stored.value;
  if (!now || now.state !== "stopped" || running.value) return null;
  return (
    <div class="row">
      <span>
        {grouped(now.done)} of {grouped(now.runs)} runs are there.
      </span>
      <button type="button" class="main" onClick={() => void work.begin({ resume: now.key })}>
        Resume
      </button>
    </div>
  );
}

/** What went wrong with runs of the sweep that is shown. */
function Failed() {
  const now = stored.value;
  if (!now?.failed.length) return null;
  return (
    <>
      {now.failed.map(([status, count, first]) => (
        <Message key={status} kind="caution">
          {`${grouped(count)} ${count === 1 ? "run" : "runs"}: ${now.layout.statuses.find(([code]) => code === status)?.[2] ?? ""} (run ${first.join(", ")}${count > first.length ? " …" : ""})`}
        </Message>
      ))}
    </>
  );
}

export function Live() {
  return (
    <>
      {work.trouble.value && <Message kind="error">{work.trouble.value}</Message>}
      {running.value ? <Running /> : <Ended />}
      <Stopped />
      <Failed />
    </>
  );
}
