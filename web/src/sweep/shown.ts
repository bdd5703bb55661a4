// The sweep that is shown: its layout, and its runs as they come.

import { batch, computed, signal } from "@preact/signals";
import { call, sentence, superseded } from "../lib/api.ts";
import { place } from "../state/route.ts";
import { watched } from "../state/jobs.ts";
import type { Layout, Line, Note, Outcome, Points, Stored } from "./types.ts";

export const work = watched<Note, Outcome>("sweep");

/** Key of the sweep that the address names. */
export const key = computed(() => (place.value.page === "sweep" ? (place.value.rest[0] ?? "") : ""));
export const stored = signal<Stored | null>(null);
/** Runs that are drawn; a new object whenever some came. */
export const runs = signal<Runs | null>(null);
export const refused = signal("");
export const lines = signal<Line[] | null>(null);
/** Number of a run that is looked at. */
export const chosen = signal<number | null>(null);

/** Runs by their number; what comes again takes the place of what was there. */
export class Runs {
  readonly rows: number[] = [];
  readonly status: number[] = [];
  private readonly columns: Record<string, (number | null)[]> = {};
  private readonly places = new Map<number, number>();
  private readonly shape: number[] | null;

  constructor(readonly layout: Layout) {
    const levels = layout.axes.map((axis) => axis.levels);
    this.shape = levels.every((one) => one !== null) ? levels.map((one) => one?.length ?? 1) : null;
  }

  take(more: Points): void {
    more.rows.forEach((row, k) => {
      let at = this.places.get(row);
      if (at === undefined) this.places.set(row, (at = this.rows.push(row) - 1));
      this.status[at] = more.status[k] ?? 0;
      for (const [name, values] of Object.entries(more.columns)) (this.columns[name] ??= [])[at] = values[k] ?? null;
    });
  }

  at = (row: number): number | undefined => this.places.get(row);

  /** Level of a run along an axis of a grid. */
  level(axis: number, row: number): number {
    let rest = row;
    for (let k = (this.shape?.length ?? 0) - 1; k > axis; k--) rest = Math.floor(rest / (this.shape?.[k] ?? 1));
    return rest % (this.shape?.[axis] ?? 1);
  }

  /** Number of the run with such levels. */
  row = (levels: number[]): number => levels.reduce((row, level, k) => row * (this.shape?.[k] ?? 1) + level, 0);

  /** A number of the run at a place, in the unit it is shown in. */
  value(name: string, at: number): number | null {
    const { axes, measures } = this.layout;
    const k = axes.findIndex((axis) => axis.name === name);
    const column = axes[k] ?? measures.find((one) => one.name === name);
    const levels = axes[k]?.levels;
    const si = levels ? levels[this.level(k, this.rows[at] ?? 0)] : this.columns[name]?.[at];
    return column && si !== null && si !== undefined ? si * column.factor + column.offset : null;
  }
}

export const isGrid = (layout: Layout): boolean => layout.axes.every((axis) => axis.levels !== null);

let loading: Promise<void> = Promise.resolve();
/** When nothing is being loaded. */
export const settled = (): Promise<void> => loading;

/** Take all that is there of a sweep. */
export const load = (wanted: string): Promise<void> => (loading = taken(wanted));

async function taken(wanted: string): Promise<void> {
  try {
    const found = await call<Stored>("sweep_points", { key: wanted }, "sweep-points");
    if (wanted !== key.peek()) return;
    const fresh = new Runs(found.layout);
    fresh.take(found.points);
    for (const note of work.job.peek()?.trail ?? []) if (note.key === wanted) takeNote(fresh, note); // came meanwhile
    batch(() => {
      if (stored.value?.key !== wanted) chosen.value = null;
      stored.value = found;
      runs.value = fresh;
      refused.value = "";
    });
  } catch (error) {
    if (!superseded(error)) refused.value = sentence(error);
  }
}

function takeNote(now: Runs, { rows, status, columns }: Note): void {
  if (rows && status && columns) now.take({ rows, status, columns });
}

/** Add the runs of notes. */
export function takeNotes(notes: Note[]): void {
  const now = runs.peek();
  if (!now || !notes.length) return;
  for (const note of notes) takeNote(now, note);
  runs.value = Object.assign(Object.create(Runs.prototype) as Runs, now);
}

export async function list(): Promise<void> {
  try {
    lines.value = (await call<{ sweeps: Line[] }>("sweeps", {}, "sweeps")).sweeps;
  } catch (error) {
    if (!superseded(error)) refused.value = sentence(error);
  }
}
