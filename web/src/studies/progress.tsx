// How far the computation of a study is, or how it ended.

import { Message } from "../ui/message.tsx";
import { Progress } from "../ui/progress.tsx";
import { cancel, cancelling, running, subject, work } from "./state.ts";

/** Progress of the study `name`; that of another one is shown with its name. */
export function StudyProgress({ name }: { name: string }) {
  const job = work.job.value;
  const mine = subject.value === name;
  const trouble = work.trouble.value && <Message kind="error">{work.trouble.value}</Message>;
  if (!job) return trouble || null;
  if (!running.value) {
    if (!mine || job.state === "done") return trouble || null;
    return <Message kind={job.state === "failed" ? "error" : "note"}>{String(job.outcome ?? "")}</Message>;
  }
  const note = job.last;
  const where = note ? `part ${note.done + 1} of ${note.of}: ${note.doing}` : "starting";
  const label = cancelling.value ? "Cancelling …" : `${mine ? "Computing" : `Computing ${subject.value}`}, ${where}`;
  return (
    <>
      {trouble}
      <Progress share={note ? note.done / note.of : null} label={label} {...(cancelling.value ? {} : { onCancel: () => void cancel() })} />
    </>
  );
}
