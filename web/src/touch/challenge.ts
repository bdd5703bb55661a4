// The challenge: hold a position by hand, for a score.

import { effect, signal } from "@preact/signals";
import { run } from "../state/run.ts";
import { beginLive, hand, inRealTime, stopLive, watchers, type Hand } from "./live.ts";
import { chooseTarget, scoreHold, type Score, type Target } from "./score.ts";

/** Time to get there, and time that counts [s]. */
export const [GRACE, LENGTH] = [5, 20];
interface Challenge {
  target: Target;
  name: string;
  /** When it began in the recording [s]. */
  from: number;
  /** Time that counted so far [s]. */
  gone: number;
  score: Score | null;
}

export const challenge = signal<Challenge | null>(null);

/** Whether a model can be held by hand: one drive that heats, and something that moves. */
export const canChallenge = (now: Hand): boolean =>
  now.drives.length === 1 && now.drives[0]!.kind === "heat" && now.drives[0]!.drive.port !== "" && chooseTarget(now.recording.before) !== null;

export function beginChallenge(): void {
  const now = hand.peek();
  const target = now && chooseTarget(now.recording.before);
  if (!now || !target) return;
  inRealTime.value = true;
  challenge.value = { target, name: now.recording.before.title, from: now.recording.end, gone: -GRACE, score: null };
}

/** Run by hand again, with a new challenge. */
export async function tryAgain(): Promise<void> {
  challenge.value = null;
  await beginLive();
  beginChallenge();
}

watchers.add((now) => {
  const own = challenge.peek();
  if (!own || own.score) return;
  const gone = now.recording.end - own.from - GRACE;
  if (gone < LENGTH) return void (challenge.value = { ...own, gone });
  const { times, values } = now.recording.last(run.peek()!.coordinate, gone);
  challenge.value = { ...own, gone: LENGTH, score: scoreHold(times, values, own.target) };
  stopLive();
});

// a challenge that is left before its end has no score
effect(() => {
  if (hand.value) return;
  inRealTime.value = false;
  if (challenge.peek() && !challenge.peek()!.score) challenge.value = null;
});
