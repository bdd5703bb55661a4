// The mechanism in space over time, from the formulas of its drawing.

import type { SceneData, Shape } from "../lib/types.ts";
import { chooseRows, highest, lowest, pickRows } from "./columns.ts";
import type { Numbers } from "./excursions.ts";
import { Computed, roundHalfEven, type Columns, type Value, type Values } from "./formulas.ts";
import type { ShapeRows, Views } from "./types.ts";

/** Pictures of a run: as many, and as few where there are many shapes. */
const MOST = 241;
const LEAST = 61;
/** Coordinates of all pictures together. */
const MOST_NUMBERS = 60_000;
/** Quantum as a share of the size of the picture. */
const FINENESS = 1e-5;

const OTHER_PARTS = "The mechanism has other parts with these parameters; this page cannot draw it.";

type Point = [number, number, number];

/** Shapes once, and where they are over time. */
export function drawScene(times: Numbers, columns: Columns, parameters: Values, { scene }: Pick<Views, "scene">): SceneData {
  const count = scene.shapes.reduce((sum, shape) => sum + 3 * shape.points.length, 0);
  const rows = chooseRows(times.length, Math.max(Math.min(MOST, Math.floor(MOST_NUMBERS / Math.max(count, 1))), LEAST));
  const known = new Computed(scene, parameters, columns, rows);
  const holds = known.holds;
  const shapes = holds ? scene.shapes : [];
  const [low, high] = findBounds(known, shapes);
  const quantum = chooseQuantum(Math.hypot(...high.map((value, k) => value - low[k]!)));
  const share = 1 / quantum;
  const place = (value: number): number => roundHalfEven(value * share) + 0; // no -0
  const still = shapes.map((shape) => shape.points.flat().every((row) => isStill(known.get(row))));
  const moving = shapes.filter((_, k) => !still[k]).flatMap((shape) => shape.points.flat()).map((row) => known.get(row));
  const turning = shapes.filter((shape) => shape.turn !== null).map((shape) => known.get(shape.turn!));
  const picture = (values: Value[], k: number): number[] => values.map((value) => (typeof value === "number" ? value : value[k]!));
  return {
    shapes: shapes.map((shape, k) => describeShape(known, shape, still[k] ? shape.points.flat().map((row) => place(known.one(row))) : null)),
    times: pickRows(times, rows),
    quantum,
    newton: scene.newton,
    frames: rows.map((_, k) => picture(moving, k).map(place)),
    turns: rows.map((_, k) => picture(turning, k)),
    low,
    high,
    ports: Object.fromEntries(Object.entries(scene.ports).map(([port, names]) => [port, { ...names, slack: listSlack(columns[names.force]!, rows) }])),
    ...(scene.sentence || !holds ? { sentence: scene.sentence || OTHER_PARTS } : {}),
  };
}

function describeShape(known: Computed, shape: ShapeRows, still: number[] | null): Shape {
  const found: Shape = { name: shape.name, kind: shape.kind, size: known.one(shape.size), count: shape.points.length, still };
  const mass = known.one(shape.mass);
  if (mass) found.mass = mass;
  if (shape.port === null) return found;
  const number = (row: number | undefined): number => (row === undefined ? 0 : known.one(row));
  return { ...found, port: shape.port, diameter: number(shape.diameter), coil: number(shape.coil), coils: number(shape.coils) };
}

const isStill = (value: Value): boolean => typeof value === "number" || value.every((one) => one === value[0]);

/** 1 where an element hangs slack, which it does without any force. */
function listSlack(force: Numbers, rows: number[]): number[] {
  const least = 1e-9 * Math.max(highest(force), -lowest(force));
  return rows.map((row) => Number(force[row]! <= least));
}

/** A round length [m] that nobody sees in a picture of a size. */
const chooseQuantum = (size: number): number => Number(`1e${Math.floor(Math.log10(Math.max(size, 1e-9) * FINENESS))}`);

function findBounds(known: Computed, shapes: ShapeRows[]): [Point, Point] {
  const points = shapes.flatMap((shape) => shape.points);
  if (!points.length) return [[0, 0, 0], [0, 0, 0]];
  const ends = (axis: 0 | 1 | 2): [number, number] => {
    const values = points.map((point) => known.get(point[axis])).map((value) => (typeof value === "number" ? [value] : value));
    return [Math.min(...values.map(lowest)), Math.max(...values.map(highest))];
  };
  const [x, y, z] = [ends(0), ends(1), ends(2)];
  return [[x[0], y[0], z[0]], [x[1], y[1], z[1]]];
}
