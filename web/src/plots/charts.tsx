// All charts of the run: curves over time at the left, further loops at the right.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Run } from "../lib/types.ts";
import { run } from "../state/run.ts";
import { Panels, Ports, WholeTime } from "./chooser.tsx";
import { planeHeight } from "./drawn.ts";
import { Exports } from "./exports.tsx";
import { Key, Loops } from "./loops.tsx";
import { Phase } from "./phase.tsx";
import { Traces } from "./traces.tsx";

/** After so long a rest, charts that are out of sight follow [ms]. */
const REST = 250;
/** What shows only its first title counts as out of sight. */
const HARDLY = "-64px";

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

/** The run that is shown; while charts are out of sight, the one after which there was a rest. The first run is
 * shown beside the mechanism before it is shown in them. */
function useCalmRun(host: { current: Element | null }): Run | null {
  const calm = useSignal(run.peek());
  useEffect(() => {
    let [seen, waiting] = [true, 0];
    const follow = (): void => void (calm.value = run.peek());
    const watch = new IntersectionObserver(
      (entries) => {
        seen = entries.at(-1)!.isIntersecting;
        if (seen) follow();
      },
      { rootMargin: HARDLY },
    );
    if (host.current) watch.observe(host.current);
    const leave = run.subscribe((now) => {
      clearTimeout(waiting);
      if (now && !calm.peek()) requestAnimationFrame(() => setTimeout(follow));
      else if (seen || !now) follow();
      else waiting = window.setTimeout(follow, REST);
    });
    return () => (leave(), watch.disconnect(), clearTimeout(waiting));
  }, [calm.value === null]);
  return calm.value;
}

export function Charts() {
  const columns = useRef<HTMLDivElement>(null);
  const now = useCalmRun(columns);
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
      <div class="charts-columns" ref={columns}>
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
