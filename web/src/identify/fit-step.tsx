// The fourth step: the fit at work. Its cost, its best numbers, and measured beside modelled.

import { digits, toShown } from "../lib/numbers.ts";
import { Message } from "../ui/message.tsx";
import { Progress } from "../ui/progress.tsx";
import { Table } from "../ui/table.tsx";
import { printed } from "./number.tsx";
import { Key, Plot } from "./plot.tsx";
import { beginFit, bestKept, endFit, fitting, goTo, isRunning, outcome, put, state } from "./state.ts";
import type { Note, Problem } from "./types.ts";

const PANELS = 8;

/** Newest note that has something. */
function newest<Name extends keyof Note>(trail: Note[], name: Name): NonNullable<Note[Name]> | undefined {
  for (let k = trail.length - 1; k >= 0; k -= 1) {
    const found = trail[k]?.[name];
    if (found !== undefined && found !== null) return found;
  }
  return undefined;
}

function Cost({ trail, noisy }: { trail: Note[]; noisy: boolean }) {
  const told = trail.filter((note) => note.cost && note.simulations !== undefined && note.cost > 0);
  if (told.length < 1) return <p class="soft">The search has not finished a run yet.</p>;
  const scale = noisy ? 1 : 100;
  return (
    <Plot
      label="Lowest root-mean-square error over the runs of the search"
      x={told.map((note) => note.simulations ?? 0)}
      xLabel="runs"
      yLabel={noisy ? "rms error / noise" : "rms error [% of range]"}
      lines={[{ label: "best so far", colour: 1, values: told.map((note) => Math.sqrt(note.cost ?? 0) * scale), dots: told.length < 3 }]}
      height={190}
      logarithmic
    />
  );
}

function Numbers({ problem, values }: { problem: Problem; values: Record<string, number> | undefined }) {
  const rows = problem.parameters.map((one) => {
    const value = values?.[one.name] ?? one.start;
    return [
      <span title={one.doc}>{one.name}</span>,
      `${digits(toShown(value, one), 5)} ${printed(one.display_unit)}`,
      <meter min={one.low} max={one.high} value={value} aria-label={`${one.name} between its bounds`} title={`${digits(toShown(one.low, one))} to ${digits(toShown(one.high, one))} ${printed(one.display_unit)}`} />,
    ];
  });
  return <Table caption="Best so far" headings={["parameter", "value", "between its bounds"]} rows={rows} right={[1]} />;
}

const LINES = [
  { label: "measured", colour: 0, dots: true },
  { label: "model, best so far", colour: 1 },
];

function Curves({ problem, curves }: { problem: Problem; curves: Note["curves"] }) {
  const panels = problem.records.flatMap((record, r) => record.outputs.map((output, k) => ({ record, output, model: curves?.[r]?.[k] })));
  return (
    <>
      <Key lines={LINES} />
      <div class="identify-panels">
        {panels.slice(0, PANELS).map(({ record, output, model }) => (
          <Plot
            key={`${record.name} ${output.name}`}
            label={`${output.long_name || output.name} of ${record.name}, measured and modelled`}
            x={record.times}
            xLabel={`time [s], ${record.name}`}
            yLabel={`${output.name}${output.display_unit ? ` [${printed(output.display_unit)}]` : ""}`}
            lines={[
              { ...LINES[0]!, values: output.measured.map((v) => (v === null ? null : toShown(v, output))) },
              { ...LINES[1]!, values: record.times.map((_, k) => (typeof model?.[k] === "number" ? toShown(model[k], output) : null)) },
            ]}
            height={220}
          />
        ))}
      </div>
      {panels.length > PANELS && <p class="soft small">{panels.length - PANELS} more are not drawn.</p>}
    </>
  );
}

function Controls({ last }: { last: Note | undefined }) {
  const stage = last?.stage === "scenario" ? "from the numbers of the scenario" : last?.stage;
  const label = last ? `${stage ?? "begun"}; ${last.simulations ?? 0} runs, ${digits(last.seconds ?? 0, 3)} s` : "reading the log, choosing steps, compiling";
  return (
    <div class="panel stack">
      <Progress share={null} label={label} />
      <div class="row">
        <button type="button" class="main" onClick={() => void endFit(true)}>
          Stop and keep the best
        </button>
        <button type="button" onClick={() => void endFit(false)}>
          Cancel
        </button>
      </div>
    </div>
  );
}

function Ended() {
  const job = fitting.job.value;
  if (!job || job.state === "running") return null;
  const dropped = job.id === state.value.dropped;
  return (
    <div class="stack">
      {dropped && <Message kind="note">The fit was cancelled without a result.</Message>}
      {!dropped && outcome.value && <Message kind="note">The fit has ended: {outcome.value.reason}.</Message>}
      {!dropped && job.state !== "done" && <Message kind="error">{typeof job.outcome === "string" ? job.outcome : "The fit was ended from outside."}</Message>}
      <div class="row">
        {outcome.value && (
          <button type="button" class="main" onClick={() => put({ step: 4 })}>
            Show the result
          </button>
        )}
        {!dropped && job.state === "cancelled" && bestKept.value && (
          <button type="button" class="main" onClick={() => void beginFit({ state: bestKept.value, finish: true })}>
            Take the best so far
          </button>
        )}
        <button type="button" onClick={() => void goTo(2)}>
          Back to the free parameters
        </button>
      </div>
    </div>
  );
}

export function FitStep() {
  const job = fitting.job.value;
  const trail = job?.trail ?? [];
  const problem = trail.find((note) => note.problem)?.problem;
  return (
    <div class="stack">
      {fitting.trouble.value && <Message kind="error">{fitting.trouble.value}</Message>}
      {(isRunning.value || (!job && !fitting.trouble.value)) && <Controls last={trail.filter((note) => note.stage).at(-1)} />}
      <Ended />
      {problem && (
        <>
          {problem.notes.map((note) => (
            <Message key={note} kind="note">
              {note}
            </Message>
          ))}
          <div class="identify-live">
            <section class="panel" aria-label="Cost">
              <Cost trail={trail} noisy={problem.noisy.length > 0} />
            </section>
            <section class="panel" aria-label="Parameters">
              <Numbers problem={problem} values={newest(trail, "values")} />
            </section>
          </div>
          <section class="panel" aria-label="Measured and modelled">
            <Curves problem={problem} curves={newest(trail, "curves")} />
          </section>
        </>
      )}
      {!job && fitting.trouble.value && (
        <button type="button" onClick={() => void goTo(2)}>
          Back to the free parameters
        </button>
      )}
    </div>
  );
}
