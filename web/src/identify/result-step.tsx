// The last step: what was found, how far to trust it, what the data leave open, and files.

import { useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { take } from "../lib/api.ts";
import { difference, digits, toShown } from "../lib/numbers.ts";
import { openInBench } from "../state/scenario.ts";
import { Message } from "../ui/message.tsx";
import { Table } from "../ui/table.tsx";
import { addFiles, beginFit, bestKept, goTo, outcome, refused, reporting, state } from "./state.ts";
import { printed } from "./number.tsx";
import { Said } from "./said.tsx";
import { VerdictPanel } from "./verdict.tsx";
import { ResultCurves } from "./result-curves.tsx";
import type { Found, Outcome, Score } from "./types.ts";

const MARKS: Record<string, string> = { "not determined": "⚠ not determined", weak: "⚠ weak", "at a bound": "⚠ at a bound" };

function parameter(one: Found): preact.ComponentChildren[] {
  const [low, high] = one.interval ?? [null, null];
  const shown = (value: number, count = 5): string => digits(toShown(value, one), count);
  return [
    <span title={one.doc}>{one.name}</span>,
    `${shown(one.value, 6)} ${printed(one.display_unit)}`,
    low === null || high === null ? "none" : `${shown(low)} to ${shown(high)}`,
    shown(one.start),
    `${shown(one.low)} to ${shown(one.high)}`,
    <span class={one.mark ? "identify-mark" : ""}>{MARKS[one.mark] ?? one.mark}</span>,
  ];
}

function score(one: Score): preact.ComponentChildren[] {
  const size = (value: number): string => `${digits(difference(value, one), 3)} ${printed(one.display_unit)}`;
  const fit = one.fit_percent === null ? "–" : `${one.fit_percent.toFixed(1)} %`;
  return [one.record, one.output, one.part, size(one.rms), fit, `${size(one.maximum)} at ${digits(one.maximum_at)} s`, size(one.bias)];
}

function Open({ found }: { found: Outcome }) {
  return (
    <section class={`message ${found.determined ? "note" : "caution"} identify-open`} aria-label="Parameters that the data do not determine">
      <h2>{found.determined ? "All free parameters are determined" : "⚠ Parameters that the data do not determine"}</h2>
      <ul>
        {[...found.open, ...found.uncertainty.filter((one) => !found.open.includes(one))].map((sentence) => (
          <li key={sentence}>
            <Said>{sentence}</Said>
          </li>
        ))}
      </ul>
    </section>
  );
}

const correlated = (value: number | null): string => (value === null ? "–" : value.toFixed(2));

function Correlations({ found }: { found: Outcome }) {
  const names = found.parameters.map((one) => one.name);
  if (names.length < 2) return null;
  const rows = found.correlation.map((row, k) => [
    names[k],
    ...row.map((value, at) => <span class={at !== k && value !== null && Math.abs(value) > 0.95 ? "identify-mark" : ""}>{correlated(value)}</span>),
  ]);
  return (
    <details class="panel">
      <summary>Correlations of the parameters</summary>
      <Table caption="Correlation; above 0.95 the data hardly separate two parameters" headings={["parameter", ...names]} rows={rows} right={names.map((_, k) => k + 1)} />
    </details>
  );
}

function Files({ found }: { found: Outcome }) {
  const report = reporting.job.value;
  const writing = report?.state === "running" ? String(report.request["what"]) : "";
  const write = (what: string): void => void reporting.begin({ key: found.fit, what });
  useSignalEffect(() => {
    const job = reporting.job.value;
    if (job?.state === "done" && job.outcome && typeof job.outcome === "object") {
      take(job.outcome.key, job.outcome.name);
      reporting.job.value = null;
    }
  });
  return (
    <div class="row">
      <button type="button" class="main" disabled={writing !== ""} onClick={() => write("material")}>
        {writing === "material" ? "Saving the material …" : "Save the material"}
      </button>
      <button type="button" disabled={writing !== ""} onClick={() => write("report")}>
        {writing === "report" ? "Writing the report …" : "Save the report"}
      </button>
      <button type="button" onClick={() => openInBench(found.scenario)}>
        Open in bench
      </button>
      {found.reason === "interrupted" && (
        <button type="button" onClick={() => void beginFit({ state: bestKept.value })}>
          Continue the search
        </button>
      )}
      <button type="button" onClick={() => void goTo(2)}>
        Start another fit
      </button>
      <button type="button" disabled={writing !== ""} onClick={() => write("terminal")}>
        {writing === "terminal" ? "Saving …" : "Save all for the command line"}
      </button>
      <label class="identify-another">
        Judge it by another log{" "}
        <input type="file" multiple onChange={(event) => void judge([...(event.currentTarget.files ?? [])])} />
      </label>
      {report?.state === "failed" && <Message kind="error">{String(report.outcome)}</Message>}
    </div>
  );
}

/** Fit again, with logs beside that are only predicted. */
async function judge(files: File[]): Promise<void> {
  if (!files.length) return;
  await addFiles(files, true);
  if (!refused.value) await beginFit();
}

export function ResultStep() {
  const found = outcome.value;
  useEffect(() => void (state.value.text || goTo(2)), []);
  if (!found) return <p class="soft">There is no result yet.</p>;
  const scores = [...found.scores].sort((a, b) => Number(a.part !== "training") - Number(b.part !== "training"));
  return (
    <div class="stack">
      <h2>
        {found.title}{" "}
        <span class="soft small">
          {found.reason}; {found.simulations} runs, {found.jacobians} with derivatives, {digits(found.seconds, 3)} s
        </span>
      </h2>
      <VerdictPanel found={found} />
      <Files found={found} />
      {found.warnings.filter((sentence) => !found.verdict.reasons.includes(sentence)).map((sentence) => (
        <Message key={sentence} kind="caution">
          ⚠ <Said>{sentence}</Said>
        </Message>
      ))}
      <Open found={found} />
      <div class="panel">
        <Table caption="Parameters, with intervals of 95 %" headings={["parameter", "value", "95 % interval", "start", "bounds", "remark"]} rows={found.parameters.map(parameter)} right={[1, 2, 3, 4]} />
      </div>
      <div class="panel">
        <Table caption="Errors" headings={["record", "output", "part", "rms", "fit", "largest", "bias"]} rows={scores.map(score)} right={[3, 4, 5, 6]} />
        {found.predictions.map((sentence) => (
          <p key={sentence} class="small">
            <Said>{sentence}</Said>
          </p>
        ))}
      </div>
      <ResultCurves found={found} />
      <details class="panel">
        <summary>Residuals: test for noise</summary>
        <ul>
          {(found.whiteness.length ? found.whiteness : ["There are too few rows for a test of whiteness."]).map((sentence) => (
            <li key={sentence}>
              <Said>{sentence}</Said>
            </li>
          ))}
        </ul>
      </details>
      <Correlations found={found} />
      {found.notes.map((note) => (
        <Message key={note} kind="note">
          <Said>{note}</Said>
        </Message>
      ))}
    </div>
  );
}
