// Runs that are kept beside the live one: their names, whether they are drawn, what differs.

import { batch, useSignal } from "@preact/signals";
import type { Run } from "../lib/types.ts";
import { openInBench } from "../state/scenario.ts";
import { pin, pinned, run, unpin, waiting, type Pinned, type Waiting } from "../state/run.ts";
import { Differences, Results } from "./differences.tsx";
import { hidden } from "./drawn.ts";
import { liveLook, pinLook } from "./palette.ts";
import { Swatch } from "./swatch.tsx";

function rename(id: number, name: string): void {
  pinned.value = pinned.value.map((one) => (one.id === id ? { ...one, name } : one));
}

function toggle(id: number): void {
  const next = new Set(hidden.value);
  if (!next.delete(id)) next.add(id);
  hidden.value = next;
}

function drop(id: number): void {
  batch(() => {
    hidden.value = new Set([...hidden.value].filter((other) => other !== id));
    unpin(id);
  });
}

function One({ one }: { one: Pinned }) {
  const off = hidden.value.has(one.id);
  return (
    <li class={off ? "off" : undefined}>
      <Swatch look={pinLook(one.id)} />
      <input
        class="pin-name"
        aria-label={`Name of pinned run ${one.id}`}
        value={one.name}
        onChange={(event) => rename(one.id, event.currentTarget.value.trim() || one.name)}
      />
      <button type="button" aria-pressed={!off} onClick={() => toggle(one.id)} aria-label={`${off ? "Show" : "Hide"} ${one.name}`}>
        {off ? "Show" : "Hide"}
      </button>
      <button type="button" onClick={() => openInBench(one.run.text)} aria-label={`Open ${one.name}`} title="Open its scenario on the bench; undo restores the present one">
        Open
      </button>
      <button type="button" class="quiet" onClick={() => drop(one.id)} aria-label={`Unpin ${one.name}`} title="Unpin">
        ✕
      </button>
    </li>
  );
}

/** A pinned run that is computed anew. */
function Coming({ one }: { one: Waiting }) {
  return (
    <li class="off">
      <Swatch look={pinLook(one.id)} /> {one.name}: {one.trouble || "is computed anew …"}
      <button type="button" class="quiet" onClick={() => drop(one.id)} aria-label={`Unpin ${one.name}`} title="Unpin">
        ✕
      </button>
    </li>
  );
}

/** Tables of differences, which are asked for while they are open. */
function Differing(props: { now: Run; pins: Pinned[] }) {
  const open = useSignal(false);
  return (
    <details class="differences" onToggle={(event) => (open.value = event.currentTarget.open)}>
      <summary>What differs</summary>
      {open.value && (
        <div class="columns">
          <Differences {...props} />
          <Results {...props} />
        </div>
      )}
    </details>
  );
}

export function Compare() {
  const now = run.value;
  if (!now) return null;
  const pins = pinned.value;
  return (
    <section class="compare" aria-label="Compare">
      <ul>
        {pins.length > 0 && (
          <li>
            <Swatch look={liveLook(0)} /> this run
          </li>
        )}
        {pins.map((one) => (
          <One key={one.id} one={one} />
        ))}
        {waiting.value.map((one) => (
          <Coming key={one.id} one={one} />
        ))}
        <li>
          <button type="button" onClick={pin} title="Keep this run in all charts, below new runs">
            Pin this run
          </button>
        </li>
      </ul>
      {pins.length > 0 && <Differing now={now} pins={pins} />}
    </section>
  );
}
