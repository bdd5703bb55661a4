// All charts of the run: curves over time at the left, loops and the phase diagram at the right.

import { run } from "../state/run.ts";
import { Panels, Ports, WholeTime } from "./chooser.tsx";
import { Exports } from "./exports.tsx";
import { Key, Loops } from "./loops.tsx";
import { Phase } from "./phase.tsx";
import { Traces } from "./traces.tsx";

export function Charts() {
  const now = run.value;
  if (!now) return null;
  return (
    <section class="charts panel" aria-label="Charts">
      <div class="charts-bar row">
        <h2>Charts</h2>
        <Ports of={now} />
        <Panels of={now} />
        <WholeTime />
        <Exports />
        <p class="soft small hint">Click: time cursor. Drag: zoom. Double click: all.</p>
      </div>
      <div class="charts-columns">
        <Traces of={now} />
        {now.ports.length > 0 && (
          <div class="loops">
            <Key of={now} />
            <Loops of={now} />
            <Phase of={now} />
          </div>
        )}
      </div>
    </section>
  );
}
