// What a model did while it was stepped by hand: samples by column, drawn as they come and kept as a run.

import { changeDocument, readToml, Written, writeToml } from "../engine/toml.ts";
import type { RunCore, Scenario } from "../engine/types.ts";
import type { Run, SceneData } from "../lib/types.ts";
import { chooseRows, endsOf, listStretches, pickRows } from "../views/columns.ts";
import { describePhase } from "../views/diagrams.ts";
import { drawScene } from "../views/drawing.ts";
import { describeRun } from "../views/run.ts";

/** Samples that are kept; of more, every second one is. */
const MOST = 6000;
/** Samples that are drawn while it goes on. */
const DRAWN = 700;
/** Rows of a drive in a document. */
const MOST_ROWS = 500;
/** Length of a jump of a drive in a document [s]. */
const JUMP = 1e-6;

export class Recording {
  readonly times: number[] = [];
  /** Columns, and profiles after them. */
  private readonly samples: number[][];
  /** Levels of drives, from when on [s]. */
  private readonly levels: [time: number, levels: number[]][] = [];
  private steps = 0;
  /** Of the calculation [s]. */
  private seconds = 0;
  private bounds: Pick<SceneData, "low" | "high">;

  constructor(
    private readonly scenario: Scenario,
    /** The run from which it began, of the same structure. */
    readonly before: Run,
  ) {
    this.samples = scenario.names.map(() => []);
    this.bounds = before.scene;
  }

  get end(): number {
    return this.times.at(-1) ?? 0;
  }

  /** A span: its samples, the levels of drives in it, and the time that it took [s]. */
  add({ times, rows, levels, seconds }: { times: Float64Array; rows: Float64Array; levels: number[]; seconds: number }): void {
    this.steps += times.length;
    this.seconds += seconds;
    const width = this.samples.length;
    const last = this.levels.at(-1)?.[1];
    if (times.length && !(last && levels.every((level, k) => Object.is(level, last[k])))) this.levels.push([this.end, levels]);
    for (let k = 0; k < times.length; k++) {
      this.times.push(times[k]!);
      for (let i = 0; i < width; i++) this.samples[i]!.push(rows[k * width + i]!);
    }
    if (this.times.length > MOST) for (const all of [this.times, ...this.samples]) halve(all);
  }

  /** The last seconds of a column. */
  last(name: string, seconds: number): { times: number[]; values: number[] } {
    const from = this.times.findIndex((time) => time >= this.end - seconds);
    return { times: this.times.slice(from), values: (this.samples[this.scenario.names.indexOf(name)] ?? []).slice(from) };
  }

  /** A number now. */
  now(name: string): number {
    return this.samples[this.scenario.names.indexOf(name)]?.at(-1) ?? NaN;
  }

  /** What is drawn while it goes on: the path so far, and where the mechanism is. */
  draw(parameters: Record<string, number>): Run {
    const { scenario, before } = this;
    const rows = chooseRows(this.times.length, DRAWN);
    const columns = Object.fromEntries(scenario.names.slice(0, scenario.columns).map((name, k) => [name, pickRows(this.samples[k]!, rows)]));
    const temperature = (port: string): string => (scenario.views.elements.prefixed ? `${port}.temperature` : "temperature");
    return {
      ...before,
      times: pickRows(this.times, rows),
      columns,
      ends: endsOf(columns),
      stretches: Object.fromEntries(scenario.ports.map((port) => [port, listStretches(columns[temperature(port)]!)])),
      phase: describePhase(columns, parameters, scenario.views),
      scene: this.drawScene(parameters),
      alarms: [],
      warnings: [],
    };
  }

  /** The mechanism now, and a moment ago; what holds all of it only grows, so that the camera stands still. */
  private drawScene(parameters: Record<string, number>): SceneData {
    const { scenario, times } = this;
    const last = [Math.max(times.length - 2, 0), times.length - 1];
    const columns = Object.fromEntries(scenario.names.slice(0, scenario.columns).map((name, k) => [name, pickRows(this.samples[k]!, last)]));
    const scene = drawScene(pickRows(times, last), columns, parameters, scenario.views);
    const { low, high } = this.bounds;
    const outer = (own: number[], known: number[], bound: (a: number, b: number) => number) => own.map((x, k) => bound(x, known[k]!)) as [number, number, number];
    this.bounds = { low: outer(scene.low, low, Math.min), high: outer(scene.high, high, Math.max) };
    return { ...scene, ...this.bounds };
  }

  /** All of it as a run, and as a document that has the same drives. */
  keep(text: string, parameters: Record<string, number>, cautions: string[]): Run {
    const { scenario, times } = this;
    const columns = Object.fromEntries(scenario.names.slice(0, scenario.columns).map((name, k) => [name, Float64Array.from(this.samples[k]!)]));
    const core: RunCore = {
      name: scenario.name, text, changes: {}, times: Float64Array.from(times), columns, track: null, profiles: {},
      status: "OK", statusTime: null, accuracy: null, steps: this.steps, rejected: 0, step: 0, ripple: 0, residual: 0,
      putIn: 0, lost: 0, accounts: [], exit: null, parameters, duration: this.end, tolerance: 1, samples: times.length, seconds: this.seconds,
      warnings: [], cautions,
    };
    const run = describeRun(core, scenario, parameters);
    return { ...run, title: `${this.before.title}, by hand`, runtime: "WebAssembly" };
  }

  /** Times and levels of a drive, with jumps between; null if there are too many. */
  private tabulate(drive: number): { times: number[]; values: number[] } | null {
    const times: number[] = [];
    const values: number[] = [];
    for (const [at, levels] of this.levels) {
      const level = levels[drive]!;
      if (values.at(-1) === level) continue;
      if (times.length) times.push(at), values.push(values.at(-1)!);
      times.push(times.length ? at + JUMP : at), values.push(level);
    }
    times.push(Math.max(this.end, (times.at(-1) ?? 0) + JUMP)), values.push(values.at(-1) ?? 0);
    return times.length <= MOST_ROWS ? { times, values } : null;
  }

  /** A document with what was done by hand as tables of the drives; null if that cannot be written. */
  write(text: string, changes: Record<string, string>, path: (drive: string) => string): string | null {
    const document = changeDocument(readToml(text), { ...changes, "run.duration": `${this.end} s` });
    for (const [k, { name, how }] of this.scenario.places.drives.entries()) {
      const found = this.tabulate(k);
      if (!found || !path(name)) return null;
      const unit = how.unit === "1" ? "" : ` ${how.unit}`;
      const list = (values: number[], spelled: string) => values.map((x) => (spelled ? `${x}${spelled}` : new Written(String(x))));
      const keys = path(name).split(".");
      let node = document;
      for (const key of keys.slice(0, -1)) {
        const below = node[key];
        if (!below || typeof below !== "object" || Array.isArray(below) || below instanceof Written) return null;
        node = below;
      }
      node[keys.at(-1)!] = { kind: "table", times: list(found.times, " s"), values: list(found.values, unit) };
    }
    return writeToml(document);
  }
}

/** Every second sample, and the last one. */
function halve(all: number[]): void {
  let kept = 0;
  for (let k = (all.length - 1) % 2; k < all.length; k += 2) all[kept++] = all[k]!;
  all.length = kept;
}
