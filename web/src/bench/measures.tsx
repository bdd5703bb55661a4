// Big numbers of the run, with their change against the run that was pinned last.

import { difference, digits, toShown } from "../lib/numbers.ts";
import { printed } from "../plots/drawn.ts";
import { pinned, run } from "../state/run.ts";
import { dangers } from "./cures.ts";
import { measures, type Measure } from "../views/results.ts";

/** A change of less than this share is none. */
const SAME = 0.002;

/** How far a number is from that of the pinned run, in words and as a sign. */
function changed(now: Measure, then: Measure | undefined): { sign: string; text: string; words: string; good: string } | null {
  if (!then || now.value === null || then.value === null || now.how.display_unit !== then.how.display_unit) return null;
  const step = now.value - then.value;
  const size = Math.abs(now.how.offset ? step / 300 : step / (then.value || now.value || 1));
  if (size < SAME) return null;
  const [sign, more] = step > 0 ? ["▲", "more than"] : ["▼", "less than"];
  const amount = now.how.offset ? `${digits(Math.abs(difference(step, now.how)), 2)} K` : then.value ? `${digits(100 * size, 2)} %` : `${digits(Math.abs(difference(step, now.how)), 2)} ${printed(now.how.display_unit)}`;
  const good = now.better === 0 ? "" : Math.sign(step) === now.better ? "better" : "worse";
  return { sign, text: amount, words: `${amount} ${more}`, good };
}

function Tile({ one, then, name }: { one: Measure; then: Measure | undefined; name: string }) {
  const unit = printed(one.how.display_unit);
  const change = changed(one, then);
  return (
    <div class={`measure ${dangers.value.some(({ kind }) => kind === one.key) ? "exceeded" : ""}`} title={one.about}>
      <dt>{one.name}</dt>
      <dd>
        <strong>{one.value === null ? "–" : digits(toShown(one.value, one.how), 3)}</strong> <span class="small soft">{one.value === null ? "not in this run" : unit}</span>
        {change && (
          <span class={`change small ${change.good}`}>
            <span aria-hidden="true">
              {change.sign} {change.text}
            </span>
            <span class="hidden">
              {change.words} “{name}”{change.good && `, which is ${change.good}`}
            </span>
          </span>
        )}
      </dd>
    </div>
  );
}

export function Measures() {
  const now = run.value;
  if (!now) return null;
  const pin = pinned.value.at(-1);
  const then = pin ? measures(pin.run) : [];
  const isSame = pin?.run === now || pin?.run.text === now.text;
  return (
    <section class={`panel measures ${pin && !isSame ? "compared" : ""}`} aria-label="Key results">
      <dl>
        {measures(now).map((one) => (
          <Tile key={one.key} one={one} then={then.find((other) => other.key === one.key)} name={pin?.name ?? ""} />
        ))}
      </dl>
      {pin && !isSame && (
        <p class="small soft measures-against">
          <span aria-hidden="true">▲▼</span> against “{pin.name}”
        </p>
      )}
    </section>
  );
}
