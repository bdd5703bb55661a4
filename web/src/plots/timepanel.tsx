// One panel of curves over time, with their names and their values at the time cursor.

import { useMemo } from "preact/hooks";
import { digits } from "../lib/numbers.ts";
import { cursor, row } from "../state/run.ts";
import { Chart } from "./chart.tsx";
import { printed, timeLimits, wholeTime, zoom } from "./drawn.ts";
import type { Look } from "./palette.ts";
import type { Level, Numbers, Picture, Shade } from "./picture.ts";
import { around, type Scale } from "./scale.ts";
import { Symbol } from "../ui/symbol.tsx";
import { Swatch } from "./swatch.tsx";

const HEIGHT = 90;
const TIME_AXIS = 36;

export interface Series {
  symbol: string;
  /** What it is called among others of its symbol. */
  word: string;
  name: string;
  unit: string;
  times: Numbers;
  values: Numbers;
  look: Look;
}

export interface TimePanelProps {
  title: string;
  /** The live run's curves. */
  series: Series[];
  /** Curves of pinned runs, drawn beneath. */
  beside: Series[];
  includes?: number[];
  shades?: Shade[];
  levels?: Level[];
  /** The time axis has its numbers here. */
  last: boolean;
}

/** Without what is but the error of rounding. */
const clean = (value: number | undefined): number | undefined => (Math.abs(value ?? 1) < 1e-12 ? 0 : value);

/** Values of the curves at the time cursor. */
function Readout({ series }: { series: Series[] }) {
  const at = row.value;
  const alike = new Set(series.map((one) => one.symbol)).size < series.length;
  return (
    <span class="readout">
      {series.map((one, k) => (
        <span key={k} title={one.name}>
          {series.length > 1 && <Swatch look={one.look} />} {alike ? one.word : <Symbol text={one.symbol} />} = {digits(clean(one.values[at]), 4)}{" "}
          {printed(one.unit)}
        </span>
      ))}
    </span>
  );
}

/** The scale of what is drawn; with those levels that are near to it. */
function scaleOf(label: string, { series, beside, includes = [], levels = [] }: TimePanelProps): Scale {
  const all = [...series, ...beside].map((one) => one.values);
  const { low, high } = around(label, all, 0.07, includes);
  const near = levels.map((level) => level.y).filter((y) => y > low - (high - low) && y < high + (high - low));
  return around(label, all, 0.07, [...includes, ...near]);
}

const TIME = "t [s]";

export function TimePanel(props: TimePanelProps) {
  const { title, series, beside, shades, levels, last } = props;
  const time = timeLimits.value;
  const first = series[0];
  const alone = series.length === 1 && first;
  const label = `${alone ? `${first.symbol.replace("_", " ")} ` : ""}[${printed(first?.unit ?? "") || "–"}]`;
  const picture = useMemo<Picture>(
    () => ({
      x: { label: TIME, low: time[0], high: time[1] },
      y: scaleOf(label, props),
      along: true,
      curves: [...beside, ...series].map((one) => ({ x: one.times, y: one.values, look: one.look, ...(alone ? {} : { name: one.symbol.replace("_", " ") }) })),
      shades,
      levels,
    }),
    [series, beside, time, shades, levels, label],
  );
  return (
    <figure class="time-panel" aria-label={title}>
      <figcaption>
        <span class="panel-title">{title}</span> <Readout series={series} />
      </figcaption>
      <Chart
        picture={picture}
        height={HEIGHT + (last ? TIME_AXIS : 0)}
        about={`${title} over time`}
        timed
        bare={!last}
        keys=""
        onPick={(x) => (cursor.value = Math.max(0, x))}
        shared={{ whole: { label: TIME, low: 0, high: wholeTime.value }, zoom: (part) => (zoom.value = part && [part.low, part.high]) }}
      />
    </figure>
  );
}
