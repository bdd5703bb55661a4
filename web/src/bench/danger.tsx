// Exceeded limits of the run, in the place of the insight, and the changes that bring the run below them.

import { useEffect } from "preact/hooks";
import { digits, toShown } from "../lib/numbers.ts";
import { capital } from "../lib/words.ts";
import { printed } from "../plots/drawn.ts";
import { AlarmItem } from "../plots/warnings.tsx";
import { run } from "../state/run.ts";
import type { Cure } from "../views/cures.ts";
import { measures } from "../views/results.ts";
import { cures, dangers, followCures, search, searchCures } from "./cures.ts";
import { tryOut } from "./insight.tsx";
import { isQuick } from "./trials.ts";

const KEYS: Record<string, string[]> = { stress: ["stress", "stroke"], temperature: ["temperature", "stroke"] };

/** Results of a cure that the reader compares: the limited quantity and the stroke. */
function effectOf(cure: Cure, kind: string): string {
  const wanted = KEYS[kind] ?? ["stroke"];
  return wanted
    .flatMap((key) => measures(cure.run).filter((one) => one.key === key && one.value !== null))
    .map((one) => `${one.name.toLowerCase()} ${digits(toShown(one.value!, one.how), 3)} ${printed(one.how.display_unit)}`)
    .join(", ");
}

function Cures({ kind }: { kind: string }) {
  if (!cures.value.length) return null;
  return (
    <ul class="cures" aria-label="Changes that keep the limit">
      {cures.value.map((cure) => (
        <li key={cure.key}>
          <button type="button" onClick={() => tryOut(cure.changes)} title="Pin this run and apply the change">
            {capital(cure.words)}
          </button>
          <span>{effectOf(cure, kind)}</span>
        </li>
      ))}
    </ul>
  );
}

function State() {
  const now = run.value;
  if (search.value === "running") return <p class="small" role="status">Running the scenario with other values …</p>;
  if (search.value === "done" && !cures.value.length) return <p class="small">No single change of load, size or heat that was tried keeps all limits.</p>;
  if (search.value === "waiting" && now && !isQuick(now)) return <button type="button" onClick={() => void searchCures()}>Find a change that keeps the limit</button>;
  return null;
}

export function Danger() {
  useEffect(followCures, []);
  const first = dangers.value[0];
  if (!first) return null;
  return (
    <section class="panel danger" aria-label="Exceeded limits">
      <ul>
        {dangers.value.map((alarm) => (
          <AlarmItem key={`${alarm.kind} ${alarm.column}`} alarm={alarm} />
        ))}
      </ul>
      <Cures kind={first.kind} />
      <State />
    </section>
  );
}
