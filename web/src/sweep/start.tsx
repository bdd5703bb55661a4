// How many runs it has, about how long it takes, and the button that starts it.

import { go } from "../state/route.ts";
import { choices, estimate, estimating, measureTime, plan, request } from "./asking.ts";
import { running } from "./following.ts";
import { work } from "./shown.ts";
import { about, grouped } from "./time.ts";
import { Message } from "../ui/message.tsx";

function Estimated() {
  const found = estimate.value;
  if (estimating.value) return <p role="status">Measuring the time of some runs …</p>;
  if (!found) return null;
  return (
    <p role="status">
      Estimate: {about(found.seconds)}. {grouped(found.tried)} {found.tried === 1 ? "run" : "runs"} took{" "}
      {found.took.toPrecision(2)} s on <code>{found.runtime}</code>, and there are {found.workers} processes, which take some
      seconds to begin. Failing runs and a busy machine take longer.
    </p>
  );
}

export function Start() {
  const now = plan.value;
  const ready = now?.runs !== null && now?.runs !== undefined;
  const waits = running.value;
  const start = (): void => {
    go("sweep"); // what is shown makes room for the new one
    void work.begin(request.value);
  };
  return (
    <div class="stack sweep-start">
      <p role="status">
        <strong>{ready ? `${grouped(now?.runs ?? 0)} runs` : choices.value.axes.length ? "Not ready" : "Choose a parameter to vary"}</strong>
        {ready && choices.value.design === "saltelli" && " (a block has two more than there are axes)"}
      </p>
      {now?.cautions.map((words) => (
        <Message key={words} kind="caution">
          {words}
        </Message>
      ))}
      <Estimated />
      <div class="row">
        <button type="button" class="main" disabled={!ready || waits} onClick={start}>
          Start
        </button>
        <button type="button" disabled={!ready || estimating.value} onClick={() => void measureTime()}>
          Estimate the time
        </button>
      </div>
      {waits && <p class="soft small">A sweep of this tab is running; cancel it first, or open another tab.</p>}
    </div>
  );
}
