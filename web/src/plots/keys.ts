// Keys that move the time cursor.

import { cursor, row, run } from "../state/run.ts";
import { duration } from "./drawn.ts";

const STEPS: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1, PageDown: -10, PageUp: 10 };

export function moveTime(event: KeyboardEvent): void {
  const now = run.value;
  if (!now || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target !== event.currentTarget) return;
  const step = STEPS[event.key];
  if (step !== undefined) {
    const to = Math.max(0, Math.min(now.times.length - 1, row.value + step * (event.shiftKey ? 10 : 1)));
    cursor.value = now.times[to] ?? 0;
  } else if (event.key === "Home") cursor.value = 0;
  else if (event.key === "End") cursor.value = duration(now);
  else return;
  event.preventDefault();
}
