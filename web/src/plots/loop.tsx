// One quantity over another, in the order of time, with a point that moves with the time cursor.

import type { ComponentChildren } from "preact";
import { cursor, run } from "../state/run.ts";
import { Chart } from "./chart.tsx";
import { moveTime } from "./keys.ts";
import { nearestRow } from "./nearest.ts";
import type { Picture } from "./picture.ts";

export interface LoopChartProps {
  title: ComponentChildren;
  about: string;
  picture: Picture;
  height: number;
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
