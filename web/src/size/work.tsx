// How far a sizing or a check is, or how it ended.

import { useSignal } from "@preact/signals";
import type { Watched } from "../state/jobs.ts";
import { Message } from "../ui/message.tsx";
import { Progress } from "../ui/progress.tsx";
import type { Note } from "./types.ts";

export function Work<Outcome>({ watched, what }: { watched: Watched<Note, Outcome>; what: string }) {
  const cancelling = useSignal(false);
  const job = watched.job.value;
  const cancel = async (): Promise<void> => {
    cancelling.value = true;
    await watched.cancel();
    cancelling.value = false;
  };
  return (
    <>
      {watched.trouble.value && <Message kind="error">{watched.trouble.value}</Message>}
      {job?.state === "running" && (
        <Progress
          share={job.last ? job.last.done / job.last.of : null}
          label={cancelling.value ? "Cancelling …" : `${what}: ${job.last ? `${job.last.done} of ${job.last.of}` : "starting"}`}
          {...(cancelling.value ? {} : { onCancel: () => void cancel() })}
        />
      )}
      {(job?.state === "failed" || job?.state === "cancelled") && (
        <Message kind={job.state === "failed" ? "error" : "note"}>{String(job.outcome ?? "")}</Message>
      )}
    </>
  );
}
