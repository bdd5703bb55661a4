// The second step: the columns over time, and which stretches of it are records of the fit.

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { digits, toShown } from "../lib/numbers.ts";
import { NumberField, printed, SECONDS } from "./number.tsx";
import { LogList, Overlay } from "./log-list.tsx";
import { Plot, type Line } from "./plot.tsx";
import { Preparation } from "./preparation.tsx";
import type { RecordsView } from "./types.ts";
import { goTo, logs, overlay, put, readOverlay, readRecords, records, state, wholeCut, type Cut } from "./state.ts";

const PANELS = 6;

function change(at: number, patch: Partial<Cut>): void {
  put({ cuts: state.value.cuts.map((one, k) => (k === at ? { ...one, ...patch } : one)) });
}

/** Two handles on one line. */
function Handles({ cut, at }: { cut: Cut; at: number }) {
  const { begin = 0, end = 1 } = records.value ?? {};
  const step = (end - begin) / 1000;
  const handle = (name: "from" | "to"): preact.JSX.Element => (
    <input
      type="range"
      min={begin}
      max={end}
      step={step}
      aria-label={`${cut.name}: ${name}`}
      aria-valuetext={`${digits(cut[name])} s`}
      value={cut[name]}
      onInput={(event) => {
        const value = Number(event.currentTarget.value);
        change(at, name === "from" ? { from: Math.min(value, cut.to - step) } : { to: Math.max(value, cut.from + step) });
      }}
    />
  );
  return (
    <div class="identify-handles">
      {handle("from")}
      {handle("to")}
    </div>
  );
}

function CutRow({ cut, at, chosen, choose }: { cut: Cut; at: number; chosen: boolean; choose: () => void }) {
  const { begin = 0, end = 0, cuts = [] } = records.value ?? {};
  return (
    <fieldset class={`panel identify-cut ${chosen ? "chosen" : ""}`} onFocusIn={choose}>
      <legend>
        Record {at + 1}
        {chosen ? " (drag in a plot to set it)" : ""}
      </legend>
      <div class="row">
        <label>
          name{" "}
          <input size={14} value={cut.name} onChange={(event) => change(at, { name: event.currentTarget.value.replaceAll(",", " ").trim() || cut.name })} />
        </label>
        <NumberField label="from" value={cut.from} how={SECONDS} onChange={(value) => change(at, { from: value ?? begin })} />
        <NumberField label="to" value={cut.to} how={SECONDS} onChange={(value) => change(at, { to: value ?? end })} />
        <label>
          1 row of{" "}
          <input type="number" min={1} max={100000} class="narrow" value={cut.every} onChange={(event) => change(at, { every: Math.max(1, Math.round(Number(event.currentTarget.value)) || 1) })} />
        </label>
        {(state.value.cuts.length > 1 || logs.value.length > 1) && (
          <label>
            <input type="checkbox" checked={cut.held} onChange={(event) => change(at, { held: event.currentTarget.checked })} /> hold out
          </label>
        )}
        <span class="soft small">{cuts[at] ? `${cuts[at].rows} rows` : ""}</span>
        {state.value.cuts.length > 1 && (
          <button type="button" onClick={() => put({ cuts: state.value.cuts.filter((_, k) => k !== at) })}>
            Remove
          </button>
        )}
      </div>
      {cuts[at]?.refused && (
        <p class="identify-wrong small" role="status">
          ⚠ {cuts[at].refused.replaceAll("`", "")}
        </p>
      )}
      <Handles cut={cut} at={at} />
    </fieldset>
  );
}

/** A loop is seen over what drives it, and not over its rows. */
const Loops = () => (overlay.value?.loops ? <Overlay /> : null);

const AS_RECORDED = 5;

/** A column as it is, in front of what was recorded where a step changed it. */
function linesOf(column: RecordsView["columns"][number], colour: number): Line[] {
  const shown = (values: (number | null)[]): (number | null)[] => values.map((v) => (v === null ? null : toShown(v, column)));
  const now = { label: column.name, colour, values: shown(column.values) };
  return column.before.length ? [{ label: "as recorded", colour: AS_RECORDED, dots: true, values: shown(column.before) }, { ...now, colour: colour === AS_RECORDED ? 0 : colour }] : [now];
}

/** The longest stretch that no record has yet; the whole if all is taken. */
function free(): [number, number] {
  const { begin = 0, end = 0 } = records.value ?? {};
  const ends = [...state.value.cuts].sort((a, b) => a.from - b.from);
  let from = begin;
  let best: [number, number] = [begin, begin];
  for (const cut of [...ends, { from: end, to: end }]) {
    if (cut.from - from > best[1] - best[0]) best = [from, cut.from];
    from = Math.max(from, cut.to);
  }
  return best[1] - best[0] > 0.02 * (end - begin) ? best : [begin, end];
}

/** The records as they are cut and put right now; after a step that changed the rows, the whole is one again. */
async function reread(): Promise<void> {
  if (!(await readRecords())) return;
  if (!state.value.cuts.length) put({ cuts: [wholeCut()] });
  if (logs.value.length > 1) await readOverlay();
}

export function RecordsStep() {
  const chosen = useSignal(0);
  const found = records.value;
  const { cuts } = state.value;
  const timing = JSON.stringify([cuts, state.value.steps, state.value.at]);
  useEffect(() => {
    const waiting = setTimeout(() => void reread(), 400);
    return () => clearTimeout(waiting);
  }, [timing]);
  if (!found) return null;
  const bands = cuts.map((cut, k) => ({ from: cut.from, to: cut.to, chosen: k === chosen.value }));
  const add = (): void => {
    const [from, to] = free();
    put({ cuts: [...cuts, { ...wholeCut(), from, to }] });
    chosen.value = cuts.length;
  };
  return (
    <div class="stack">
      <p class="soft">
        {found.rows.toLocaleString("en")} rows from {digits(found.begin)} s to {digits(found.end)} s. A fit compares records: take the stretches that
        are to be explained, and leave out the rest. {found.dropped > 0 && `${found.dropped} rows could not be read and are left out.`}
      </p>
      <LogList />
      {logs.value.length > 1 && <h2>{state.value.file?.name}</h2>}
      {logs.value.length < 2 && <Loops />}
      <Preparation />
      {cuts.map((cut, k) => (
        <CutRow key={k} cut={cut} at={k} chosen={k === chosen.value} choose={() => (chosen.value = k)} />
      ))}
      <div class="row">
        <button type="button" onClick={add}>
          Add a record
        </button>
        <button type="button" class="main" disabled={found.cuts.some((one) => one.refused)} onClick={() => void goTo(2)}>
          Next: scenario
        </button>
      </div>
      <div class="identify-panels">
        {found.columns.slice(0, PANELS).map((column, k) => (
          <Plot
            key={column.name}
            label={`${column.name} over time, with the records shaded`}
            x={column.times}
            xLabel={found.timed ? "time [s]" : "row, each taken as 1 s"}
            yLabel={`${column.name}${column.display_unit ? ` [${printed(column.display_unit)}]` : ""}`}
            lines={linesOf(column, k % 6)}
            height={170}
            bands={bands}
            range={[found.begin, found.end]}
            onSelect={(from, to) => change(chosen.value, { from, to })}
          />
        ))}
      </div>
      {found.columns.length > PANELS && <p class="soft small">{found.columns.length - PANELS} more columns are not drawn.</p>}
    </div>
  );
}
