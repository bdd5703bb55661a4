// The last seconds of a model that runs by hand: its position, and what it should be.

import { digits, toShown } from "../lib/numbers.ts";
import { printed } from "../plots/drawn.ts";
import type { Run } from "../lib/types.ts";
import type { Recording } from "./recording.ts";

const SECONDS = 15;
const [WIDE, HIGH] = [600, 90];
const MOST = 300;

interface Props {
  recording: Recording;
  now: Run;
  /** What should be held [SI], and how far from it counts as held. */
  target: number;
  band: number;
}

export function Strip({ recording, now, target, band }: Props) {
  const { times, values } = recording.last(now.coordinate, SECONDS);
  const how = now.outputs[now.coordinate];
  if (!how || times.length < 2) return null;
  const { low, high } = limits(recording, now, target);
  const end = times.at(-1)!;
  const x = (time: number): number => WIDE * (1 - (end - time) / SECONDS);
  const y = (value: number): number => HIGH * (1 - (value - low) / (high - low));
  const every = Math.ceil(times.length / MOST);
  const points = times.flatMap((time, k) => (k % every === 0 || k === times.length - 1 ? [`${x(time).toFixed(1)},${y(values[k]!).toFixed(1)}`] : [])).join(" ");
  const error = Math.abs((values.at(-1)! - target) * how.factor);
  return (
    <figure class="live-strip">
      <svg viewBox={`0 0 ${WIDE} ${HIGH}`} preserveAspectRatio="none" role="img" aria-label={`${how.long_name} of the last ${SECONDS} s, and the position to hold`}>
        <rect class="strip-band" x="0" width={WIDE} y={y(target + band)} height={Math.max(y(target - band) - y(target + band), 1)} />
        <line class="strip-target" x1="0" x2={WIDE} y1={y(target)} y2={y(target)} />
        <polyline class="strip-curve" points={points} />
      </svg>
      <figcaption class="small">
        <strong>{digits(toShown(values.at(-1)!, how), 3)}</strong> {printed(how.display_unit)} of {digits(toShown(target, how), 3)} {printed(how.display_unit)}; error {digits(error, 2)} {printed(how.display_unit)}
      </figcaption>
    </figure>
  );
}

/** Range of the position in the run before, and of the target. */
function limits({ before }: Recording, now: Run, target: number): { low: number; high: number } {
  const [first = 0, last = 0] = before.ends[now.coordinate] ?? [];
  const room = 0.1 * (Math.max(last, target) - Math.min(first, target)) || 1;
  return { low: Math.min(first, target) - room, high: Math.max(last, target) + room };
}
