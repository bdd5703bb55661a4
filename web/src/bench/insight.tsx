// One sentence on what limits this run, and what would help: each answer is a run of its own.

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { digits, toShown } from "../lib/numbers.ts";
import { send } from "../form/state.ts";
import type { Run } from "../lib/types.ts";
import { capital } from "../lib/words.ts";
import { printed } from "../plots/drawn.ts";
import { pin, pinned, run } from "../state/run.ts";
import { Table } from "../ui/table.tsx";
import { measures } from "../views/results.ts";
import type { Changes } from "../views/remedies.ts";
import { dangers } from "./cures.ts";
import { followTrials, insight, promised, remedies, sorted, trials, trying, tryRemedies, type Trial } from "./trials.ts";

const COLUMNS = ["stroke", "error", "up", "down", "temperature", "stress", "energy"];

/** Pin the run that is shown, and apply changes. */
export function tryOut(changes: Changes): void {
  if (!pinned.value.some((one) => one.run === run.value)) pin();
  send(changes);
}

/** A number stays on the line of its unit. */
const unbroken = (text: string): string => text.replaceAll(/(\d) /g, "$1\u00a0");

/** Results of trials next to the run itself. */
function Trials({ now, of, caption }: { now: Run; of: Trial[]; caption: string }) {
  const own = measures(now).filter((one) => COLUMNS.includes(one.key));
  const cells = (of: Run | null, wires = 1): string[] =>
    own.map(({ key }) => {
      const found = of && measures(of).find((one) => one.key === key);
      const factor = key === "energy" ? wires : 1;
      return !found || found.value === null ? "–" : `${digits(factor * toShown(found.value, found.how), 3)} ${printed(found.how.display_unit)}`;
    });
  const rows = of.map((trial) => [
    <span title={trial.remedy.about}>{capital(trial.remedy.words)}</span>,
    ...cells(trial.run, trial.remedy.wires),
    trial.run?.alarms.length ? `${trial.run.alarms.length} beyond limits` : "",
    trial.run ? (
      <button type="button" onClick={() => tryOut(trial.changes)} aria-label={`Try it: ${trial.remedy.words}`} title="Pin this run and open the changed scenario on the bench">
        Try it
      </button>
    ) : (
      "cannot be run"
    ),
  ]);
  return (
    <Table
      caption={caption}
      headings={["With", ...own.map((one) => one.name), "Warnings", ""]}
      rows={[["This run", ...cells(now), now.alarms.length ? `${now.alarms.length} beyond limits` : "", ""], ...rows]}
      right={own.map((_, k) => k + 1)}
    />
  );
}

/** Trials that help; the others are behind a summary. */
function Outcomes({ now }: { now: Run }) {
  const { helpful, others } = sorted.value;
  if (!trials.value.length) return null;
  return (
    <>
      {helpful.length > 0 && <Trials now={now} of={helpful} caption="What helps, the largest effect first; each row is a run" />}
      {!helpful.length && !trying.value && <p>None of the tried changes helps.</p>}
      {others.length > 0 && (
        <details class="small insight-about">
          <summary>Tried without success ({others.length})</summary>
          <Trials now={now} of={others} caption="Changes that do not help, or that exceed a limit" />
        </details>
      )}
    </>
  );
}

function About() {
  return (
    <details class="small insight-about">
      <summary>How this is computed</summary>
      <p>
        Times come from the curves of this run: contraction from the start of heating to 90 % of the stroke, return from the end of heating to 10 %. What would help is not
        estimated: the scenario is run again with the change. Where wires are to get as hot as they did, up to four runs find the heat for that.
      </p>
      <p>There is no fatigue model. The available sources give a number of cycles only for one stress of straight wires; see the page Size.</p>
    </details>
  );
}

export function Insight() {
  const open = useSignal(false);
  useEffect(followTrials, []);
  const now = run.value;
  const said = insight.value;
  // what is open stays in step with the next run
  useEffect(() => {
    if (open.value && !trying.value && remedies.value.length) void tryRemedies(true);
  }, [now, remedies.value.length, trying.value]);
  if (!now || !said || dangers.value.length) return null;
  const ask = (): void => {
    open.value = !open.value;
    if (open.value) void tryRemedies(true);
  };
  return (
    <section class="panel insight" aria-label="What limits this run" aria-busy={trying.value}>
      <div class="insight-said">
        <p>
          {unbroken(said.sentence)} <span class="insight-promise">{unbroken(promised.value)}</span>
        </p>
        {remedies.value.length > 0 && (
          <button type="button" aria-expanded={open.value} onClick={ask}>
            What would help?
          </button>
        )}
      </div>
      {open.value && (
        <>
          {trying.value && (
            <p class="small soft" role="status">
              Trying {trials.value.length + 1} of {remedies.value.length} …
            </p>
          )}
          <Outcomes now={now} />
          <About />
        </>
      )}
    </section>
  );
}
