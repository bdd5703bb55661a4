// Where all points of a mechanism are at a time, between the pictures that the server sent.

import type { SceneData, Shape } from "../lib/types.ts";
import { drawnAt, type Cut } from "./cuts.ts";

const TURNING = ["pulley", "rotor"];

export class Motion {
  /** x, y, z of all points of all shapes [m]. */
  readonly places: Float64Array;
  /** Where each shape begins in `places`. */
  readonly starts: number[] = [];
  /** Angle of each shape [rad]. */
  readonly turns: number[];
  /** Length of the diagonal of the whole motion, as drawn [m]. */
  readonly extent: number;
  readonly low: [number, number, number];
  readonly high: [number, number, number];

  private readonly moving: { start: number; length: number }[] = [];
  private readonly turning: number[] = [];

  constructor(
    readonly data: SceneData,
    readonly cuts: Cut[] = [],
  ) {
    let start = 0;
    data.shapes.forEach((shape, k) => {
      this.starts.push(start);
      if (!shape.still) this.moving.push({ start, length: 3 * shape.count });
      if (TURNING.includes(shape.kind)) this.turning.push(k);
      start += 3 * shape.count;
    });
    this.places = new Float64Array(start);
    this.turns = data.shapes.map(() => 0);
    this.low = data.low.map((x, axis) => drawnAt(cuts, axis, x)) as [number, number, number];
    this.high = data.high.map((x, axis) => drawnAt(cuts, axis, x)) as [number, number, number];
    this.extent = Math.hypot(...this.high.map((high, k) => high - (this.low[k] ?? 0))) || 1;
    data.shapes.forEach((shape, k) => {
      shape.still?.forEach((value, i) => (this.places[(this.starts[k] ?? 0) + i] = this.drawn(i % 3, value * data.quantum)));
    });
    this.at(data.times[0] ?? 0);
  }

  /** Go to a time [s]. */
  at(time: number): void {
    const { data } = this;
    const { before, share } = this.between(time);
    const first = data.frames[before] ?? [];
    const second = data.frames[before + 1] ?? first;
    let from = 0;
    for (const { start, length } of this.moving) {
      for (let i = 0; i < length; i++, from++) {
        const a = first[from] ?? 0;
        this.places[start + i] = this.drawn(i % 3, (a + share * ((second[from] ?? a) - a)) * data.quantum);
      }
    }
    this.turning.forEach((shape, k) => {
      const a = data.turns[before]?.[k] ?? 0;
      this.turns[shape] = a + share * ((data.turns[before + 1]?.[k] ?? a) - a);
    });
  }

  /** Whether the element at a port hangs slack at a time [s]. */
  slack(port: string, time: number): boolean {
    const { before, share } = this.between(time);
    return this.data.ports[port]?.slack[share > 0.5 ? before + 1 : before] === 1;
  }

  private drawn(axis: number, x: number): number {
    return this.cuts.length ? drawnAt(this.cuts, axis, x) : x;
  }

  /** The picture before a time, and how far it is to the next one. */
  private between(time: number): { before: number; share: number } {
    return between(this.data.times, time);
  }
}

/** The row before a time, and how far it is to the next one (0 to 1). */
export function between(times: number[], time: number): { before: number; share: number } {
  let low = 0;
  let high = Math.max(times.length - 1, 0);
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) <= time) low = middle;
    else high = middle;
  }
  const begin = times[low] ?? 0;
  const width = (times[high] ?? begin) - begin;
  return { before: low, share: width > 0 ? Math.min(Math.max((time - begin) / width, 0), 1) : 0 };
}

/** A column at a time [s], in its unit. */
export function valueAt(times: number[], column: number[] | undefined, time: number): number {
  const { before, share } = between(times, time);
  const a = column?.[before] ?? NaN;
  return share ? a + share * ((column?.[before + 1] ?? a) - a) : a;
}

/** What must be equal for one scene to go on in the objects of another. */
export const structure = (shapes: Shape[]): string =>
  shapes.map((s) => [s.name, s.kind, s.count, s.coil ? Math.round(s.coils ?? 0) : ""].join("|")).join(";");

/** 1, 2 or 5 times a power of ten, at most so large. */
export function round(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return (value >= 5 * power ? 5 : value >= 2 * power ? 2 : 1) * power;
}
