// All charts of the run: curves over time at the left, further loops at the right.

import { run } from "../state/run.ts";
import { Panels, Ports, WholeTime } from "./chooser.tsx";
import { planeHeight } from "./drawn.ts";
import { Exports } from "./exports.tsx";
import { Key, Loops } from "./loops.tsx";
import { Phase } from "./phase.tsx";
import { Traces } from "./traces.tsx";

/** The hysteresis loop and the phase diagram, which stand beside the mechanism. */
export function Planes() {
  const now = run.value;
  if (!now?.ports.length) return null;
  return (
    <section class="planes panel" aria-label="Loop and phase diagram">
      <Loops of={now} isBeside />
      <Key of={now} />
      <Phase of={now} height={planeHeight.value} />
    </section>
  );
}

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
        {now.loops.length > 1 && (
          <div class="loops">
            <Key of={now} />
            <Loops of={now} isBeside={false} />
          </div>
        )}
      </div>
    </section>
  );
}
