// The wires that were judged: those that do, and on demand the others with their reasons.

import { useSignal } from "@preact/signals";
import { digits } from "../lib/numbers.ts";
import type { Candidate, Sizing } from "./types.ts";

const NEAREST = 5;
/** Columns of numbers stand to the right; the first ones are words. */
const WORDS = 4;

/** Rows that are shown: those that do, or all, or the nearest. */
function visible(candidates: Candidate[], all: boolean): number[] {
  const every = candidates.map((_, k) => k);
  if (all) return every;
  const good = every.filter((k) => candidates[k]?.feasible);
  return good.length > 0 ? good : every.slice(0, NEAREST);
}

const ORDERS: [name: string, key: (found: Candidate) => number][] = [
  ["robust first, then least energy", () => 0],
  ["least energy in a cycle", (found) => found.drive?.energy ?? Infinity],
  ["most spare in every limit", (found) => found.tightest.share],
  ["fewest wires", (found) => found.count],
];

interface RowProps {
  found: Candidate;
  number: number;
  chosen: boolean;
  onChoose: () => void;
}

function Row({ found, number, chosen, onChoose }: RowProps) {
  const cells = found.cells.slice(1, -1);
  const reason = found.reasons[0];
  return (
    <>
      <tr class={`choosable${reason ? " failing" : ""}`} aria-selected={chosen || undefined} onClick={onChoose}>
        <td>
          <button type="button" aria-pressed={chosen} aria-label={`Show wire ${number}: ${found.size}, ${found.alloy} °C`} onClick={onChoose}>
            {number}
          </button>
        </td>
        <td class={found.feasible ? "does" : "does-not"}>{found.feasible ? (found.frail.length ? "✓ meets" : "✓ robust") : "✗ no"}</td>
        {cells.map((cell, k) => (
          <td key={k} class={k + 1 >= WORDS ? "right" : undefined}>
            {cell}
          </td>
        ))}
        <td>
          {digits(100 * found.tightest.share, 3)} % {found.tightest.name}
        </td>
      </tr>
      {reason && (
        <tr class="reason" aria-selected={chosen || undefined} onClick={onChoose}>
          <td />
          <td colSpan={cells.length + 2}>{reason}</td>
        </tr>
      )}
    </>
  );
}

interface Props {
  sizing: Sizing;
  all: boolean;
  onAll: (all: boolean) => void;
  chosen: number | null;
  onChoose: (chosen: number) => void;
}

export function Candidates({ sizing, all, onAll, chosen, onChoose }: Props) {
  const { candidates, columns } = sizing;
  const good = candidates.filter((found) => found.feasible).length;
  const robust = candidates.filter((found) => found.feasible && found.frail.length === 0).length;
  const order = useSignal(0);
  const key = ORDERS[order.value]?.[1] ?? (() => 0);
  const does = (k: number): number => Number(!candidates[k]?.feasible);
  const rows = visible(candidates, all).sort((a, b) => does(a) - does(b) || key(candidates[a] as Candidate) - key(candidates[b] as Candidate));
  return (
    <section class="panel stack candidates" aria-label="Wires">
      <div class="row">
        <span role="status">
          {good === 0 ? "No wire meets the request. The nearest come first." : `${good} of ${candidates.length} wires meet the request, best first. ${robust || "None"} of them ${robust < 2 ? "is" : "are"} robust (10 K warmer, 20 % more load).`}
        </span>
        <label class="row">
          Order
          <select value={order.value} onChange={(event) => (order.value = Number(event.currentTarget.value))}>
            {ORDERS.map(([name], k) => (
              <option key={name} value={k}>
                {name}
              </option>
            ))}
          </select>
        </label>
        <label class="row">
          <input type="checkbox" checked={all} onChange={(event) => onAll(event.currentTarget.checked)} />
          Show rejected wires
        </label>
      </div>
      <div class="scrolling" tabIndex={0} role="region" aria-label="Table of wires">
        <table>
          <thead>
            <tr>
              <th scope="col">no.</th>
              <th scope="col">verdict</th>
              {columns.slice(1, -1).map((heading, k) => (
                <th key={heading} scope="col" class={k + 1 >= WORDS ? "right" : undefined}>
                  {heading}
                </th>
              ))}
              <th scope="col">most used limit</th>
            </tr>
          </thead>
          <tbody>
            {rows.map((k) => (
              <Row key={k} found={candidates[k] as Candidate} number={k + 1} chosen={chosen === k} onChoose={() => onChoose(k)} />
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
