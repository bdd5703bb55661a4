// One quantity over another, in the order of time, with a point that moves with the time cursor.

import { useMemo } from "preact/hooks";
import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { cursor, run } from "../state/run.ts";
import { Chart } from "./chart.tsx";
import type { Mark, Picture } from "./picture.ts";

type Limits = [number, number];

export interface LoopChartProps {
  title: ComponentChildren;
  about: string;
  picture: Picture;
  height: number;
}

/** Row whose moving point is nearest, as the eye measures distance. */
function nearest(marks: Mark[], x: number, y: number, wide: number, high: number): number {
  let [best, found] = [Infinity, -1];
  for (const mark of marks) {
    for (let i = 0; i < mark.x.length; i++) {
      const dx = ((mark.x[i] as number) - x) / wide;
      const dy = ((mark.y[i] as number) - y) / high;
      const far = dx * dx + dy * dy;
      if (far < best) [best, found] = [far, i];
    }
  }
  return found;
}

export function LoopChart({ title, about, picture, height }: LoopChartProps) {
  const part = useSignal<{ x: Limits; y: Limits } | null>(null);
  const zoomed = part.value;
  const shown = useMemo<Picture>(
    () => (zoomed ? { ...picture, xLimits: zoomed.x, yLimits: zoomed.y } : picture),
    [picture, zoomed],
  );
  const pick = (x: number, y: number): void => {
    const [a, b] = shown.xLimits;
    const [c, d] = shown.yLimits;
    const at = nearest(picture.marks ?? [], x, y, b - a, d - c);
    const time = run.value?.times[at];
    if (time !== undefined) cursor.value = time;
  };
  return (
    <figure class="loop" aria-label={about}>
      <figcaption>
        <span class="panel-title">{title}</span>
        {zoomed && (
          <button type="button" class="quiet small" onClick={() => (part.value = null)}>
            Show all
          </button>
        )}
      </figcaption>
      <Chart
        picture={shown}
        height={height}
        about={about}
        onPick={pick}
        onZoom={(x, y) => (part.value = { x, y })}
        onReset={() => (part.value = null)}
      />
    </figure>
  );
}
