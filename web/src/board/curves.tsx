// What the board says, over its own time: a chart for each quantity.

import { useMemo } from "preact/hooks";
import { digits } from "../lib/numbers.ts";
import { Chart } from "../plots/chart.tsx";
import { printed, shownValues } from "../plots/drawn.ts";
import { liveLook } from "../plots/palette.ts";
import type { Picture } from "../plots/picture.ts";
import { around } from "../plots/scale.ts";
import { Swatch } from "../plots/swatch.tsx";
import { columns, outputs } from "./state.ts";

/** Quantities that are drawn first; the others are below. */
const FIRST = ["position", "duty", "resistance", "temperature"];
const HIDDEN = ["time", "status"];
/** What a filter says of its own doubts is in the log, and not drawn. */
const DOUBTS = /_std$|correlation|\.nis$/;
const HEIGHT = 132;

const AS_IT_IS = { display_unit: "", factor: 1, offset: 0 };

/** What a column measures, whoever says it. */
const quantity = (name: string): string => name.replace(/^true |^wanted |^estimated\./, "");

/** Columns by what they measure. */
function panels(names: string[]): [string, string[]][] {
  const found = new Map<string, string[]>();
  for (const name of names) {
    if (HIDDEN.includes(name) || DOUBTS.test(name)) continue;
    found.set(quantity(name), [...(found.get(quantity(name)) ?? []), name]);
  }
  const place = (what: string): number => (FIRST.includes(what) ? FIRST.indexOf(what) : FIRST.length);
  return [...found].sort(([a], [b]) => place(a) - place(b));
}

const title = (what: string): string => what.replace(/[_.]/g, " ").replace(/^./, (letter) => letter.toUpperCase());
const SAID: [string, string][] = [["true ", "in the emulator"], ["wanted ", "wanted"], ["estimated.", "estimated"]];
const who = (name: string): string => SAID.find(([head]) => name.startsWith(head))?.[1] ?? "measured";
/** What a chart shows in any case. */
const INCLUDED: Record<string, number[]> = { position: [0], duty: [0], alarm: [0, 1] };

function Panel({ what, names }: { what: string; names: string[] }) {
  const all = columns.value;
  const times = all["time"] ?? [];
  const how = outputs.value[names[0] ?? ""] ?? AS_IT_IS;
  const series = names.map((name) => shownValues(all[name] ?? [], outputs.value[name] ?? AS_IT_IS));
  const unit = printed(how.display_unit);
  const picture = useMemo<Picture>(
    () => ({
      x: { label: "t [s]", low: times[0] ?? 0, high: Math.max(times.at(-1) ?? 1, (times[0] ?? 0) + 0.1) },
      y: around(unit ? `[${unit}]` : "", series, 0.07, INCLUDED[what]),
      along: true,
      curves: series.map((y, k) => ({ x: times, y, look: liveLook(k), name: who(names[k] ?? "") })),
    }),
    [all, unit],
  );
  return (
    <figure class="time-panel" aria-label={title(what)}>
      <figcaption>
        <span class="panel-title">{title(what)}</span>{" "}
        <span class="readout">
          {names.map((name, k) => (
            <span key={name}>
              {names.length > 1 && <Swatch look={liveLook(k)} />} {names.length > 1 || name.startsWith("true ") ? who(name) : ""} {digits(series[k]?.at(-1), 4)} {unit}
            </span>
          ))}
        </span>
      </figcaption>
      <Chart picture={picture} height={HEIGHT} about={`${title(what)} over time`} />
    </figure>
  );
}

export function Curves() {
  const found = panels(Object.keys(columns.value));
  if (!columns.value["time"]?.length) return null;
  return (
    <div class="board-curves">
      {found.map(([what, names]) => (
        <Panel key={what} what={what} names={names} />
      ))}
    </div>
  );
}
