// The score of a challenge, to be shared or beaten.

import { digits } from "../lib/numbers.ts";
import { printed } from "../plots/drawn.ts";
import { Share } from "../share/share.tsx";
import { openDoor } from "../start/doors.ts";
import { run } from "../state/run.ts";
import { challenge, LENGTH, tryAgain } from "./challenge.ts";

export function ChallengeResult() {
  const own = challenge.value;
  const how = run.value?.outputs[run.value.coordinate];
  if (!own?.score || !how) return null;
  const { score, target } = own;
  const spell = (value: number): string => `${digits(Math.abs(value * how.factor), 2)} ${printed(how.display_unit)}`;
  const note = `I held ${target.words} by hand: ${score.points} of 100 points`;
  return (
    <section class="panel challenge" aria-label="Score">
      <p>
        <strong class="challenge-points">{score.points}</strong> of 100 points: for {score.points} % of {LENGTH} s you held {target.words} within ± {spell(target.band)}.
        The error was {spell(score.rms)} RMS.
      </p>
      <div class="row">
        <Share note={note} />
        <button type="button" onClick={() => void tryAgain()}>
          Try again
        </button>
        <button type="button" onClick={() => void openDoor("closed_loop")}>
          Let a controller do it
        </button>
        <button type="button" onClick={() => (challenge.value = null)}>
          Close
        </button>
      </div>
    </section>
  );
}
