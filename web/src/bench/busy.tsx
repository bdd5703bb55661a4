// Shows how far a run is, if it takes long enough to be noticed.

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { isStatic } from "../engine/local.ts";
import { lookAtCall, type CallNote } from "../lib/api.ts";
import { host } from "../lib/host.ts";
import { cancelRun, computing } from "../state/run.ts";
import { Progress } from "../ui/progress.tsx";

/** From when a run is shown, and how often its progress is read [ms]. */
const [TOLD, OFTEN] = [500, 400];

/** Whether a run takes long. */
export const busy = signal(false);
const note = signal<CallNote | null>(null);

/** A static page and the kernel of a notebook answer when they are done. */
const isWatched = (): boolean => !isStatic() && !host;

async function look(): Promise<void> {
  const found = await lookAtCall("run").catch(() => null);
  if (busy.peek() && found) note.value = found;
}

function follow(): () => void {
  let waiting = 0;
  const show = (): void => {
    busy.value = true;
    if (isWatched()) void look();
    waiting = window.setTimeout(show, OFTEN);
  };
  const leave = computing.subscribe((now) => {
    clearTimeout(waiting);
    note.value = null;
    busy.value = false;
    if (now) waiting = window.setTimeout(show, TOLD);
  });
  return () => (clearTimeout(waiting), leave());
}

export function Busy() {
  useEffect(follow, []);
  if (!busy.value) return <div class="busy small" />;
  const { doing, done } = note.value ?? { doing: "simulating", done: null };
  const label = `${doing[0]!.toUpperCase()}${doing.slice(1)}${done === null ? " …" : `: ${Math.round(100 * done)} %`}`;
  return (
    <div class="busy small">
      <Progress share={done} label={label} {...(isWatched() ? { onCancel: cancelRun } : {})} />
    </div>
  );
}
