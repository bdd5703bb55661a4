// Fit a model to a log, step by step: file, records, scenario, fit, result.

import { useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { FileStep } from "../identify/file-step.tsx";
import { FitStep } from "../identify/fit-step.tsx";
import { RecordsStep } from "../identify/records-step.tsx";
import { ResultStep } from "../identify/result-step.tsx";
import { ScenarioStep } from "../identify/scenario-step.tsx";
import { busy, fitting, goTo, isRunning, outcome, put, refused, state, STEPS } from "../identify/state.ts";
import { Message } from "../ui/message.tsx";

const SHOWN = [FileStep, RecordsStep, ScenarioStep, FitStep, ResultStep];

/** Whether a step can be gone to. */
function isOpen(step: number): boolean {
  const { file, columns, text } = state.value;
  const mapped = file !== null && columns.some((one) => one.name);
  return [true, mapped, mapped, mapped && text !== "" && fitting.job.value !== null, outcome.value !== null][step] ?? false;
}

function Steps() {
  return (
    <ol class="identify-steps" aria-label="Steps">
      {STEPS.map((name, k) => (
        <li key={name}>
          <button type="button" aria-current={state.value.step === k ? "step" : undefined} disabled={!isOpen(k)} onClick={() => void (k < 3 ? goTo(k) : put({ step: k }))}>
            <span aria-hidden="true">{k + 1}</span> {name}
          </button>
        </li>
      ))}
    </ol>
  );
}

/** Come back to where the tab was: a fit goes on while the page is away. */
async function resume(): Promise<void> {
  const { step, file } = state.value;
  await fitting.resume();
  if (file && step < 3) await goTo(step);
}

let watching = "";

export function Page() {
  useEffect(() => void resume(), []);
  useSignalEffect(() => {
    const job = fitting.job.value;
    if (job?.state === "running") watching = job.id;
    if (outcome.value && job && watching === job.id) {
      watching = "";
      put({ step: 4 });
    }
  });
  const { step } = state.value;
  const Step = SHOWN[step] ?? FileStep;
  return (
    <div class="identify stack" aria-busy={busy.value !== "" || isRunning.value}>
      <div class="row">
        <h1>Identify</h1>
        <Steps />
        <span class="soft small" role="status">
          {busy.value}
        </span>
      </div>
      {refused.value && <Message kind="error">{refused.value}</Message>}
      <Step />
    </div>
  );
}
