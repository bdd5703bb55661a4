// One quantity over another, in the order of time, with a point that moves with the time cursor.

import type { ComponentChildren } from "preact";
import { cursor, run } from "../state/run.ts";
import { Chart } from "./chart.tsx";
import { moveTime } from "./keys.ts";
import type { Mark, Picture } from "./picture.ts";

export interface LoopChartProps {
  title: ComponentChildren;
  about: string;
  picture: Picture;
  height: number;
}

/** Row whose moving point is nearest, as the eye measures distance. */
export function nearestRow(marks: Mark[], x: number, y: number, wide: number, high: number): number {
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
  const pick = (x: number, y: number): void => {
    const at = nearestRow(picture.marks ?? [], x, y, picture.x.high - picture.x.low, picture.y.high - picture.y.low);
    const time = run.value?.times[at];
    if (time !== undefined) cursor.value = time;
  };
  return (
    <figure class="loop" aria-label={about}>
      <figcaption>
        <span class="panel-title">{title}</span>
      </figcaption>
      <Chart picture={picture} height={height} about={about} onPick={pick} onKey={moveTime} keys="Arrow keys move the time cursor." />
    </figure>
  );
}
