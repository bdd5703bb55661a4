// Printed and computed values of a study as a picture: how far each computed value is from its printed value.

import { useSignal } from "@preact/signals";
import { digits } from "../lib/numbers.ts";
import { printed } from "../plots/drawn.ts";
import { listPairs, MOST, placeOn, type Pair } from "./pairs.ts";
import type { Claim } from "./types.ts";
import { VerdictMark } from "./verdict.tsx";

const TICKS: [factor: number, label: string][] = [[1 / MOST, "÷10"], [1 / 2, "÷2"], [1, "equal"], [2, "×2"], [MOST, "×10"]];

const percent = (place: number): string => `${(50 * (1 + 0.94 * place)).toFixed(2)}%`;

function Band({ pair }: { pair: Pair }) {
  const { tolerance } = pair.claim;
  if (tolerance === null) return null;
  const ends = [pair.printed - tolerance, pair.printed + tolerance].map((value) => placeOn(value, pair.printed)).sort((a, b) => a - b) as [number, number];
  return <span class="tolerance" style={{ left: percent(ends[0]), right: `calc(100% - ${percent(ends[1])})` }} />;
}

function Row({ pair }: { pair: Pair }) {
  const { claim } = pair;
  const unit = claim.unit === "1" ? "" : ` ${printed(claim.unit)}`;
  return (
    <li class={`pair ${claim.verdict.replaceAll(" ", "-")}`}>
      <span class="pair-words">
        <span>{claim.statement}</span>
        <VerdictMark verdict={claim.verdict} />
      </span>
      <span class="pair-value">
        <span class="soft small">paper</span> {digits(pair.printed)}
        {unit}
      </span>
      <span class="pair-axis" aria-hidden="true">
        {TICKS.map(([factor]) => (
          <i key={factor} class={factor === 1 ? "equal" : ""} style={{ left: percent(placeOn(factor, 1)) }} />
        ))}
        <Band pair={pair} />
        <b style={{ left: percent(placeOn(pair.computed, pair.printed)) }} />
      </span>
      <span class="pair-value">
        <span class="soft small">ours</span> {digits(pair.computed)}
        {unit}
      </span>
    </li>
  );
}

/** Rows that are shown at first. */
const FEW = 8;

export function Comparison({ claims }: { claims: Claim[] }) {
  const all = useSignal(false);
  const pairs = listPairs(claims);
  if (!pairs.length) return null;
  const shown = all.value ? pairs : pairs.slice(0, FEW);
  return (
    <section class="panel stack comparison" aria-label="Printed and computed values">
      <h2>Printed and computed values</h2>
      <p class="soft small">A point is our value; the middle line is the printed value, and the bar its tolerance. Misprints are circled.</p>
      <div class="pair-ticks small soft" aria-hidden="true">
        <span>
          {TICKS.map(([factor, label]) => (
            <i key={label} style={{ left: percent(placeOn(factor, 1)) }}>
              {label}
            </i>
          ))}
        </span>
      </div>
      <ul>
        {shown.map((pair) => (
          <Row key={pair.claim.id} pair={pair} />
        ))}
      </ul>
      {pairs.length > FEW && (
        <button type="button" aria-expanded={all.value} onClick={() => (all.value = !all.value)}>
          {all.value ? "Show fewer" : `Show all ${pairs.length}`}
        </button>
      )}
    </section>
  );
}
