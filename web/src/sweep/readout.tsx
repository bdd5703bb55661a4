// The numbers of the run that is looked at.

import { digits } from "../lib/numbers.ts";
import { openRun } from "./bench.ts";
import { chosen, key, runs } from "./shown.ts";
import type { Column } from "./types.ts";

function Value({ one, row }: { one: Column; row: number }) {
  const now = runs.value;
  const at = now?.at(row);
  const axis = now?.layout.axes.findIndex((other) => other.name === one.name) ?? -1;
  const levels = now?.layout.axes[axis]?.levels;
  const level = levels && now ? levels[now.level(axis, row)] : undefined;
  const value = level !== undefined ? level * one.factor + one.offset : at === undefined ? null : (now?.value(one.name, at) ?? null);
  return (
    <div>
      <dt>{one.short}</dt>
      <dd>
        {digits(value)} {value !== null && one.display_unit}
      </dd>
    </div>
  );
}

export function Readout({ over }: { over: number | null }) {
  const now = runs.value;
  const row = over ?? chosen.value;
  if (!now || !key.value) return null;
  if (row === null) return <p class="soft small">Choose a run in the picture to see its values and to open it on the bench.</p>;
  const at = now.at(row);
  const code = at === undefined ? null : now.status[at];
  const state = code === null ? "not made yet" : (now.layout.statuses.find(([one]) => one === code)?.[1] ?? "");
  return (
    <div class="sweep-readout">
      <dl aria-live="polite" aria-label={`Run ${row}`}>
        <div>
          <dt>run</dt>
          <dd>
            {row} ({state.replaceAll("_", " ")})
          </dd>
        </div>
        {[...now.layout.axes, ...now.layout.measures].map((one) => (
          <Value key={one.name} one={one} row={row} />
        ))}
      </dl>
      <button type="button" disabled={chosen.value === null} onClick={() => chosen.value !== null && void openRun(chosen.value)}>
        Open run {chosen.value ?? row} in the bench
      </button>
    </div>
  );
}
