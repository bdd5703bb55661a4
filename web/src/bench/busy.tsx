// Says that a run is being made, if it takes long enough to be noticed.

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { isStatic } from "../engine/local.ts";
import { host } from "../lib/host.ts";
import { cancelRun, computing, run } from "../state/run.ts";

/** From when a run is told, and from when it is told why [ms]. */
const [TOLD, EXPLAINED] = [500, 2500];

/** 0: nothing to tell; 1: a run is made; 2: it takes long. */
export const busy = signal<0 | 1 | 2>(0);

function follow(): () => void {
  let waiting: number[] = [];
  const stop = (): void => waiting.forEach(clearTimeout);
  const leave = computing.subscribe((now) => {
    stop();
    if (!now) busy.value = 0;
    else waiting = [window.setTimeout(() => (busy.value = 1), TOLD), window.setTimeout(() => (busy.value = 2), EXPLAINED)];
  });
  return () => (stop(), leave());
}

export function Busy() {
  useEffect(follow, []);
  const what = run.value ? "Simulating the changed scenario" : "Simulating";
  return (
    <div class="busy small row">
      <p role="status">
        {busy.value > 0 && `${what} …`}
        {busy.value > 1 && " A new kind of part is compiled once, which takes some seconds."}
      </p>
      {busy.value > 0 && !isStatic() && !host && ( // the kernel of a notebook answers when it is done
        <button type="button" onClick={cancelRun}>
          Cancel
        </button>
      )}
    </div>
  );
}
