// Playing: the cursor goes on with the time of the clock, at a speed, until the end or round again.

import { computed, effect, signal } from "@preact/signals";
import { before, cursor, run } from "../state/run.ts";
import { keepSignals } from "../state/session.ts";

/** Times as fast as the clock; "fit" is what makes a run last `USUAL` seconds. */
export type Speed = number | "fit";
export const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
const USUAL = 8;
/** Longest step of the clock that counts [s]: after a pause of the page it does not jump. */
const LONGEST = 0.25;

export const speed = signal<Speed>("fit");
export const loops = signal(true);
export const playing = signal(false);
keepSignals("player", { loops });

export const begin = computed(() => run.value?.times[0] ?? 0);
export const end = computed(() => run.value?.times.at(-1) ?? 0);

/** Two digits are enough; a model that runs by hand goes as fast as the run from which that began. */
export const fitting = computed(() => {
  const times = (before.value ?? run.value)?.times;
  return Number((((times?.at(-1) ?? 0) - (times?.[0] ?? 0)) / USUAL).toPrecision(2)) || 1;
});
/** Seconds of the run in a second of the clock. */
export const rate = (): number => (speed.value === "fit" ? fitting.value : speed.value);

let frame = 0;
let last = 0;

function tick(now: number): void {
  frame = 0;
  if (!playing.peek()) return;
  const seconds = Math.min((now - last) / 1000, LONGEST);
  last = now;
  const next = cursor.peek() + seconds * rate();
  if (next < end.peek()) cursor.value = next;
  else if (loops.peek()) cursor.value = begin.peek();
  else {
    cursor.value = end.peek();
    playing.value = false;
  }
  if (playing.peek()) frame = requestAnimationFrame(tick);
}

// the only loop there is, and only while something plays
effect(() => {
  if (playing.value && !frame) {
    last = performance.now();
    frame = requestAnimationFrame(tick);
  } else if (!playing.value && frame) {
    cancelAnimationFrame(frame);
    frame = 0;
  }
});

export function toggle(): void {
  if (!run.value) return;
  if (!playing.value && cursor.value >= end.value) cursor.value = begin.value;
  playing.value = !playing.value;
}

export const pause = (): void => void (playing.value = false);

/** Go to a time; what plays goes on from there. */
export const goTo = (time: number): void => void (cursor.value = Math.min(Math.max(time, begin.peek()), end.peek()));

/** One sample on or back. */
export function step(by: number): void {
  pause();
  const times = run.value?.times ?? [];
  const now = cursor.value;
  const others = times.filter((time) => (by > 0 ? time > now + 1e-9 : time < now - 1e-9));
  const found = by > 0 ? others[0] : others.at(-1);
  if (found !== undefined) cursor.value = found;
}
