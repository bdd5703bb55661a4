// What is written over the picture: what is pointed at, what is left out, masses, and names on demand.

import { Vector3 } from "three";
import type { Shape } from "../lib/types.ts";
import type { Cast } from "./cast.ts";
import { lengthOf } from "./cuts.ts";
import type { Word } from "./labels.ts";
import type { Hit } from "./pick.ts";
import type { Reading } from "./stage.ts";

/** So many elements have their values beside their names. */
const FEW = 4;
/** Kinds that are named, the first ones first. */
const NAMED = ["wire", "weight", "phalanx", "fingertip", "palm", "plate", "pulley", "motor", "rotor", "beam", "cylinder", "slider", "spring", "object", "link"];

const FLAT = ["plate", "palm"];

const hoverWords = (cast: Cast, reading: Reading, hover: Hit | null, shape?: Shape): Word[] =>
  hover && shape ? [{ text: reading.words(shape, cast.motion.extent).join("\n"), at: hover.point, kind: "hover" }] : [];

/** How much of a length is left out, once for each direction. */
function cutWords({ breaks, motion: { cuts } }: Cast): Word[] {
  return [...new Set(cuts.map((cut) => cut.axis))].flatMap((axis): Word[] => {
    const along = cuts.filter((cut) => cut.axis === axis).sort((a, b) => lengthOf(b) - lengthOf(a));
    const mark = breaks.find((one) => one.mark.object.visible && one.mark.cut === along[0])?.mark;
    const lost = along.reduce((sum, cut) => sum + lengthOf(cut), 0);
    return mark ? [{ text: `${Number((1000 * lost).toPrecision(3))} mm not drawn`, at: mark.at, kind: "cut", beside: axis === 2 }] : [];
  });
}

const massWords = (shapes: Shape[], middle: (k: number) => Vector3): Word[] =>
  shapes.flatMap((shape, k): Word[] =>
    shape.mass ? [{ text: tellMass(shape.mass), at: middle(k).add(new Vector3(0, 0, -1.45 * shape.size)), kind: "mass" }] : [],
  );

/** Names, and what elements read if there are few: of many it would hide the mechanism. */
function nameWords(cast: Cast, reading: Reading, middle: (k: number) => Vector3): Word[] {
  const { shapes } = cast.motion.data;
  const few = cast.wires <= FEW;
  const rank = (k: number): number => (shapes[k]?.port !== undefined && !few ? NAMED.length : NAMED.indexOf(shapes[k]?.kind ?? ""));
  const order = shapes.map((_, k) => k).filter((k) => NAMED.includes(shapes[k]?.kind ?? ""));
  return order
    .sort((a, b) => rank(a) - rank(b))
    .map((k): Word => {
      const [name = "", , value] = reading.words(shapes[k] as Shape, cast.motion.extent);
      return { text: value && few && shapes[k]?.port ? `${name}: ${value}` : name, at: middle(k), kind: "name", beside: isUpright(cast.targets[k]?.points ?? []) };
    });
}

/** All words about a mechanism, the most important first. */
export function wordsOf(cast: Cast | null, reading: Reading | null, hover: Hit | null, named: boolean): Word[] {
  if (!cast || !reading) return [];
  const { shapes } = cast.motion.data;
  const middle = (k: number): Vector3 => midst(cast.targets[k]?.points ?? [], FLAT.includes(shapes[k]?.kind ?? ""));
  const over = hover ? shapes[cast.targets.indexOf(hover.target)] : undefined;
  return [
    ...hoverWords(cast, reading, hover, over),
    ...cutWords(cast),
    ...massWords(shapes, middle),
    ...(named ? nameWords(cast, reading, middle) : []),
  ];
}

/** Whether a line stands: words above its middle would lie on it. */
function isUpright(points: Vector3[]): boolean {
  const [first, last] = [points[0], points.at(-1)];
  return !!first && !!last && Math.abs(last.z - first.z) > 2 * Math.hypot(last.x - first.x, last.y - first.y);
}

/** A mass in words. */
const tellMass = (kilograms: number): string =>
  kilograms < 1 ? `${Number((1000 * kilograms).toPrecision(3))} g` : `${Number(kilograms.toPrecision(3))} kg`;

/** The middle of a line, or of a plate's corners. */
function midst(points: Vector3[], flat = false): Vector3 {
  if (flat) return points.reduce((sum, point) => sum.add(point), new Vector3()).divideScalar(points.length || 1);
  const k = Math.max(1, Math.floor(points.length / 2));
  const [a = new Vector3(), b = a] = points.length === 2 ? points : [points[k - 1], points[k]];
  return a.clone().lerp(b, 0.5);
}
