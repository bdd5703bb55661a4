// The pictures of a sweep: map or curve of a grid, scatter of anything, front, indices.

import { useSignal } from "@preact/signals";
import { tickText } from "../plots/scale.ts";
import { ColumnChoice } from "./field.tsx";
import { FrontView } from "./front.tsx";
import { IndicesView } from "./indices.tsx";
import { curveOf, mapOf, scatterOf } from "./looks.ts";
import { Plane } from "./plane.tsx";
import { Readout } from "./readout.tsx";
import { isGrid, runs, type Runs } from "./shown.ts";
import type { Axis } from "./types.ts";

type View = "map" | "curve" | "scatter" | "front" | "indices";
const NAMES: Record<View, string> = { map: "Map", curve: "Curve", scatter: "Scatter", front: "Pareto front", indices: "Sensitivity" };
interface ViewProps {
  now: Runs;
  onLook: (row: number | null) => void;
}

function viewsOf({ layout }: Runs): View[] {
  const grid: View[] = !isGrid(layout) ? [] : layout.axes.length > 1 ? ["map", "curve"] : ["curve"];
  return [...grid, "scatter", "front", "indices"];
}

/** A slider over the levels of an axis that is not drawn. */
function Level({ axis, stride, level, onChange }: { axis: Axis; stride: number; level: number; onChange: (level: number) => void }) {
  const count = axis.levels?.length ?? 1;
  const value = (axis.levels?.[level] ?? 0) * axis.factor + axis.offset;
  const words = `${tickText(value)} ${axis.display_unit}`;
  return (
    <label class="sweep-level">
      {axis.short}: {words}
      <input
        type="range" min={0} max={Math.floor((count - 1) / stride)} value={level / stride} aria-valuetext={words}
        onInput={(event) => onChange(event.currentTarget.valueAsNumber * stride)}
      />
    </label>
  );
}

function Grid({ now, onLook, flat }: ViewProps & { flat: boolean }) {
  const { axes, measures, strides } = now.layout;
  const x = useSignal(0);
  const y = useSignal(1);
  const levels = useSignal<number[]>(axes.map(() => 0));
  const name = useSignal(measures[0]?.name ?? "");
  const measure = measures.find((one) => one.name === name.value) ?? measures[0];
  if (!measure) return null;
  const placeOf = (wanted: string): number => axes.findIndex((axis) => axis.name === wanted);
  const across = (wanted: string): void => {
    if (placeOf(wanted) === y.value) y.value = x.value;
    x.value = placeOf(wanted);
  };
  const up = (wanted: string): void => {
    if (placeOf(wanted) === x.value) x.value = y.value;
    y.value = placeOf(wanted);
  };
  const others = axes.map((_, k) => k).filter((k) => k !== x.value && (flat || k !== y.value));
  const picture = flat ? curveOf(now, x.value, levels.value, measure) : mapOf(now, x.value, y.value, levels.value, measure);
  return (
    <>
      <div class="sweep-line">
        <ColumnChoice id="view-measure" label={flat ? "Up" : "Colour"} all={measures} value={measure.name} onChange={(value) => (name.value = value)} />
        {axes.length > 1 && <ColumnChoice id="view-x" label="Across" all={axes} value={axes[x.value]?.name ?? ""} onChange={across} />}
        {!flat && <ColumnChoice id="view-y" label="Up" all={axes} value={axes[y.value]?.name ?? ""} onChange={up} />}
        {others.map((k) => (
          <Level
            key={k} axis={axes[k] as Axis} stride={strides[k] ?? 1} level={levels.value[k] ?? 0}
            onChange={(level) => (levels.value = levels.value.map((one, at) => (at === k ? level : one)))}
          />
        ))}
      </div>
      <Plane picture={picture} label={flat ? `Curve of ${measure.short}` : `Map of ${measure.short}`} onLook={onLook} />
      <Key picture={(picture.spots ?? []).map((spot) => spot.state)} flat={flat} />
    </>
  );
}

/** What the looks of cells and crosses mean, of those that are there. */
function Key({ picture, flat }: { picture: string[]; flat: boolean }) {
  const has = (state: string): boolean => picture.includes(state);
  const words = [
    has("failed") && (flat ? "cross on the lower edge: failed" : "hatched: failed"),
    !flat && has("never") && "dotted: never happened",
    !flat && has("missing") && "empty: not made yet",
  ].filter(Boolean);
  return words.length ? <p class="soft small">{words.join("; ")}</p> : null;
}

function Scatter({ now, onLook }: ViewProps) {
  const { axes, measures } = now.layout;
  const all = [...axes, ...measures];
  const named = useSignal([axes[0]?.name ?? "", measures[0]?.name ?? "", axes[1]?.name ?? measures[1]?.name ?? ""]);
  const [x, y, colour] = named.value.map((name) => all.find((one) => one.name === name));
  if (!x || !y) return null;
  const put = (k: number) => (name: string): void => void (named.value = named.value.map((one, at) => (at === k ? name : one)));
  return (
    <>
      <div class="sweep-line">
        <ColumnChoice id="view-x" label="Across" all={all} value={x.name} onChange={put(0)} />
        <ColumnChoice id="view-y" label="Up" all={all} value={y.name} onChange={put(1)} />
        <ColumnChoice id="view-colour" label="Colour" all={all} none="none" value={colour?.name ?? ""} onChange={put(2)} />
      </div>
      <Plane picture={scatterOf(now, x, y, colour ?? null)} label={`${y.short} over ${x.short}`} onLook={onLook} />
    </>
  );
}

export function Pictures() {
  const now = runs.value;
  const wanted = useSignal<View | null>(null);
  const over = useSignal<number | null>(null);
  if (!now) return null;
  const views = viewsOf(now);
  const view = wanted.value && views.includes(wanted.value) ? wanted.value : (views[0] ?? "scatter");
  const look = (row: number | null): void => void (over.value = row);
  const thinned = now.layout.strides.some((stride) => stride > 1);
  return (
    <section class="panel stack" aria-label="Picture">
      <div class="sweep-tabs" role="group" aria-label="Kind of picture">
        {views.map((one) => (
          <button key={one} type="button" aria-pressed={one === view} onClick={() => (wanted.value = one)}>
            {NAMES[one]}
          </button>
        ))}
      </div>
      {(view === "map" || view === "curve") && <Grid key={view} now={now} onLook={look} flat={view === "curve"} />}
      {view === "scatter" && <Scatter now={now} onLook={look} />}
      {view === "front" && (
        <FrontView now={now} onLook={look}>
          <Readout over={over.value} />
        </FrontView>
      )}
      {view === "indices" && <IndicesView now={now} />}
      {(view === "map" || view === "curve" || view === "scatter") && <Readout over={over.value} />}
      {thinned && <p class="soft small">The picture shows a part of the runs. The front, the indices and the exports use all runs.</p>}
    </section>
  );
}
