// Energies over time, and what has become of them at the time cursor.

import { useMemo } from "preact/hooks";
import { digits } from "../lib/numbers.ts";
import type { Course, Run } from "../lib/types.ts";
import { row } from "../state/run.ts";
import { beside, panelChoice, shownValues } from "./drawn.ts";
import { liveLook, type Look } from "./palette.ts";
import { TimePanel, type Series } from "./timepanel.tsx";

export const ENERGY = "energy";
export const energyShown = (): boolean => panelChoice.value[ENERGY] ?? true;

const series = (of: Run, course: Course, look: Look): Series => ({
  symbol: course.symbol,
  word: course.key,
  name: course.long_name,
  unit: course.display_unit,
  times: of.times,
  values: shownValues(course.values, { factor: course.factor, offset: 0 }),
  look,
});

/** Courses of one unit stand together. */
function grouped(of: Run): Course[][] {
  const groups = new Map<string, Course[]>();
  for (const course of of.energy.courses) groups.set(course.display_unit, [...(groups.get(course.display_unit) ?? []), course]);
  return [...groups.values()];
}

function Efficiency({ of }: { of: Run }) {
  const share = of.energy.efficiency?.[row.value];
  if (share === null || share === undefined) return null;
  return (
    <p class="soft small">
      Efficiency up to the cursor, work over electrical energy: <output>η = {digits(100 * share, 3)} %</output>
    </p>
  );
}

function Group({ of, courses, last }: { of: Run; courses: Course[]; last: boolean }) {
  const pins = beside.value;
  const parts = useMemo(
    () => ({
      series: courses.map((course, k) => series(of, course, liveLook(k))),
      beside: pins.flatMap((one) =>
        one.run.energy.courses
          .filter((other) => courses.some((course) => course.key === other.key))
          .map((course) => series(one.run, course, one.look)),
      ),
    }),
    [of, courses, pins],
  );
  return <TimePanel title={courses.length === 3 ? "energy" : "mechanical work"} {...parts} last={last} />;
}

export function EnergyPanels({ of }: { of: Run }) {
  const groups = useMemo(() => grouped(of), [of]);
  if (!energyShown()) return null;
  return (
    <>
      {groups.map((courses, k) => (
        <Group key={`${courses[0]?.display_unit}${k}`} of={of} courses={courses} last={k === groups.length - 1} />
      ))}
      <Efficiency of={of} />
      {of.energy.sentence && <p class="soft small">{of.energy.sentence}</p>}
    </>
  );
}
