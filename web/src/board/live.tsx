// The board now: armed or not, how far, what the link lost; and its log once it has ended.

import { take } from "../lib/api.ts";
import { Message } from "../ui/message.tsx";
import { Progress } from "../ui/progress.tsx";
import { armed, counts, openInIdentify, isRunning, outcome, share, stage, stopRun, stopping, work } from "./state.ts";

function Counters() {
  const now = counts.value;
  if (!now) return null;
  const shown: [string, number][] = [["frames", now.good], ["lost", now.lost], ["doubled", now.doubled], ["garbled", now.garbled], ["late", now.reordered]];
  return (
    <dl class="board-counts" aria-label="Link">
      {shown.map(([name, value]) => (
        <div key={name} class={value && name !== "frames" ? "some" : ""}>
          <dt>{name}</dt>
          <dd>{value.toLocaleString("en")}</dd>
        </div>
      ))}
    </dl>
  );
}

function Running() {
  return (
    <div class={`panel row board-bar ${armed.value ? "board-heats" : ""}`} role="region" aria-label="Board">
      <strong class={armed.value ? "board-armed" : "soft"} role="status">
        {armed.value ? "ARMED" : "not armed"}
      </strong>
      <Progress share={share.value} label={stopping.value ? "Stopping …" : stage.value} />
      <button type="button" class="board-stop" disabled={stopping.value} onClick={() => void stopRun()}>
        Stop and disarm
      </button>
    </div>
  );
}

function Ended() {
  const job = work.job.value;
  const found = outcome.value;
  if (!job || isRunning.value) return null;
  if (!found) return <Message kind={job.state === "cancelled" ? "caution" : "error"}>{`${String(job.outcome ?? "")} A board that hears nothing disarms by itself.`}</Message>;
  return (
    <>
      {found.ended && <Message kind="caution">{found.ended}</Message>}
      <Message kind="note">{found.safe}</Message>
      <div class="row">
        <button type="button" class="main" disabled={!found.key} onClick={() => take(found.key, found.name)}>
          Download log
        </button>
        <button type="button" disabled={!found.key} onClick={() => void openInIdentify()}>
          Open in Identify
        </button>
      </div>
    </>
  );
}

export function Live() {
  return (
    <>
      {work.trouble.value && <Message kind="error">{work.trouble.value}</Message>}
      {isRunning.value ? <Running /> : <Ended />}
      <Counters />
    </>
  );
}
