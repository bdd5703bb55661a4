// The Pareto front of two outputs, found anew as runs come.

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { call, sentence, superseded } from "../lib/api.ts";
import { digits } from "../lib/numbers.ts";
import { Message } from "../ui/message.tsx";
import { Table } from "../ui/table.tsx";
import { Choice, ColumnChoice } from "./field.tsx";
import { joined, scatterOf } from "./looks.ts";
import { Plane } from "./plane.tsx";
import { chosen, key, runs, type Runs } from "./shown.ts";
import { grouped } from "./time.ts";
import type { Column } from "./types.ts";

interface Front {
  rows: number[];
  values: Record<string, (number | null)[]>;
  count: number;
  compared: number;
  left_out: [number, string][];
  /** Why there is none yet. */
  why: string;
}

const SHOWN = 30;
const AIMS = ["max", "min"] as const;
const EVERY = 700;

function Goal({ id, all, name, aim, onChange }: { id: string; all: Column[]; name: string; aim: string; onChange: (name: string, aim: string) => void }) {
  return (
    <>
      <ColumnChoice id={id} label={id === "goal-0" ? "Across" : "Up"} all={all} value={name} onChange={(value) => onChange(value, aim)} />
      <Choice id={`${id}-aim`} label="shall be" value={aim} onChange={(value) => onChange(name, value)}>
        {AIMS.map((one) => (
          <option key={one}>{one}</option>
        ))}
      </Choice>
    </>
  );
}

function Listed({ front, all }: { front: Front; all: Column[] }) {
  const stride = Math.max(Math.ceil(front.rows.length / SHOWN), 1);
  const places = front.rows.map((_, k) => k).filter((k) => k % stride === 0);
  const names = Object.keys(front.values);
  const columns = names.map((name) => all.find((one) => one.name === name)).filter((one) => one !== undefined);
  const cell = (one: Column, k: number): string => {
    const si = front.values[one.name]?.[k];
    return digits(si === null || si === undefined ? null : si * one.factor + one.offset);
  };
  const rows = places.map((k) => [
    <button type="button" class="quiet" onClick={() => (chosen.value = front.rows[k] ?? null)}>{front.rows[k]}</button>,
    ...columns.map((one) => cell(one, k)),
  ]);
  return (
    <Table
      caption={`Front: ${grouped(front.count)} of ${grouped(front.compared)} runs`} rows={rows} right={columns.map((_, k) => k + 1)}
      headings={["run", ...columns.map((one) => (one.display_unit ? `${one.short} [${one.display_unit}]` : one.short))]}
      chosen={places.findIndex((k) => front.rows[k] === chosen.value)}
    />
  );
}

export function FrontView({ now, onLook, children }: { now: Runs; onLook: (row: number | null) => void; children: ComponentChildren }) {
  const { axes, measures } = now.layout;
  const all = [...measures, ...axes];
  const goals = useSignal<[string, string][]>([
    [measures[1]?.name ?? axes[0]?.name ?? "", "min"],
    [measures[0]?.name ?? "", "max"],
  ]);
  const front = useSignal<Front | null>(null);
  const refused = useSignal("");
  useEffect(() => {
    const names = (aim: string): string[] => goals.value.filter((goal) => goal[1] === aim).map((goal) => goal[0]);
    const ask = async (): Promise<void> => {
      try {
        front.value = await call<Front>("sweep_front", { key: key.peek(), minimise: names("min"), maximise: names("max") }, "sweep-front");
        refused.value = front.value.why;
      } catch (error) {
        if (!superseded(error)) [front.value, refused.value] = [null, sentence(error)];
      }
    };
    const waiting = setTimeout(() => void ask(), front.peek() ? EVERY : 0);
    return () => clearTimeout(waiting);
  }, [runs.value, goals.value]);
  const change = (k: number) => (name: string, aim: string): void =>
    void (goals.value = goals.value.map((goal, at) => (at === k ? [name, aim] : goal)));
  const [x, y] = goals.value.map(([name]) => all.find((one) => one.name === name));
  if (!x || !y) return <Message kind="note">A front needs two outputs.</Message>;
  const picture = scatterOf(now, x, y, null);
  const rows = new Set(front.value?.rows);
  return (
    <>
      <div class="sweep-line">
        {goals.value.map(([name, aim], k) => (
          <Goal key={k} id={`goal-${k}`} all={all} name={name} aim={aim} onChange={change(k)} />
        ))}
      </div>
      {refused.value && <Message kind="note">{refused.value}</Message>}
      <Plane picture={{ ...joined(picture, (spot) => rows.has(spot.row)), quiet: true }} label={`Pareto front of ${x.short} and ${y.short}`} onLook={onLook} />
      {front.value?.left_out.map(([count, why]) => (
        <p key={why} class="soft small">
          {grouped(count)} runs are left out: {why}.
        </p>
      ))}
      {children}
      {front.value && front.value.count > 0 && <Listed front={front.value} all={all} />}
    </>
  );
}
