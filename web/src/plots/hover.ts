// What of a picture is under the pointer, or next to what was looked at last.

import { digits } from "../lib/numbers.ts";
import { edges, type Box, type Curve, type Picture, type Spot } from "./picture.ts";
import { share, valueAt, type Numbers } from "./scale.ts";

export interface Found {
  /** Where it is, in shown units. */
  x: number;
  y: number;
  /** Number of the sample of its curve, or of the spot. */
  index: number;
  curve: number;
  spot?: Spot;
  /** What is told of it; each line with the number of its colour. */
  lines: { words: string; colour?: number }[];
}

/** How near a point must be to be meant [px], and how many curves are told of at once. */
const [NEAR, MOST] = [24, 7];

/** A label such as T [°C], in two. */
function partsOf(label: string): [name: string, unit: string] {
  const [, name = label, unit = ""] = /^(.*?)\s*\[([^\]]*)\]/.exec(label) ?? [];
  return [name, unit === "–" ? "" : unit];
}

export function writeReading(label: string, value: number | null, name?: string): string {
  const [own, unit] = partsOf(label);
  const called = name || own;
  return `${called}${called && " = "}${digits(value, 4)} ${unit}`.trim();
}

/** Number of the sample that is nearest, where the numbers rise. */
export function nearestIn(x: Numbers, value: number, length = x.length): number {
  let [low, high] = [0, length - 1];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((x[middle] as number) < value) low = middle + 1;
    else high = middle;
  }
  const before = (x[low - 1] as number | undefined) ?? -Infinity;
  return value - before < (x[low] as number) - value ? low - 1 : low;
}

const lengthOf = (curve: Curve): number => Math.min(curve.x.length, curve.y.length);

/** A sample of a curve; along x with the values that all curves have there. */
function foundSample(picture: Picture, curve: number, index: number): Found | null {
  const of = picture.curves[curve];
  const [x, y] = [of?.x[index] as number, of?.y[index] as number];
  if (!of || !Number.isFinite(x + y)) return null;
  const here = picture.along ? picture.curves.map((one) => ({ one, value: one.y[nearestIn(one.x, x, lengthOf(one))] as number })) : [{ one: of, value: y }];
  const told = here.filter(({ value }) => Number.isFinite(value));
  const lines = told.slice(-MOST).map(({ one, value }) => ({ words: writeReading(picture.y.label, value, one.name), colour: one.look.colour }));
  if (told.length > MOST) lines.push({ words: `and ${told.length - MOST} more`, colour: -1 });
  return { x, y, index, curve, lines: [{ words: writeReading(picture.x.label, x) }, ...lines] };
}

export function foundSpot(picture: Picture, spot: Spot): Found {
  const lines = [{ words: writeReading(picture.x.label, spot.x) }];
  lines.push({ words: writeReading(picture.y.label, spot.state === "failed" && !picture.cells ? null : spot.y) });
  if (picture.colour) lines.push({ words: writeReading(picture.colour.label, spot.value) });
  if (spot.state !== "ok") lines.push({ words: { failed: "failed", never: "never happened", missing: "not made yet" }[spot.state] });
  return { x: spot.x, y: spot.y, index: picture.spots?.indexOf(spot) ?? 0, curve: -1, spot, lines };
}

/** Place among cells with such limits; -1 outside. */
function cellOf(limits: number[], at: number): number {
  const after = limits.findIndex((limit) => limit > at);
  return after < 1 ? -1 : after - 1;
}

/** What is near to a point of the box [px]. */
export function lookAt(picture: Picture, { width, height }: Pick<Box, "width" | "height">, px: number, py: number): Found | null {
  const { spots, cells, curves } = picture;
  const far = (x: number, y: number): number => Math.hypot(share(picture.x, x) * width - px, (1 - share(picture.y, y)) * height - py);
  if (cells && spots) {
    const [ix, iy] = [cellOf(edges(picture.x, cells.xs), px / width), cellOf(edges(picture.y, cells.ys), 1 - py / height)];
    const spot = ix < 0 || iy < 0 ? undefined : spots[ix * cells.ys.length + iy];
    return spot ? foundSpot(picture, spot) : null;
  }
  let nearest = NEAR;
  if (spots) {
    let found: Spot | null = null;
    for (const spot of spots) {
      const apart = far(spot.x, spot.y);
      if (apart < nearest) [found, nearest] = [spot, apart];
    }
    return found && foundSpot(picture, found);
  }
  let [curve, index] = [-1, -1];
  if (picture.along) nearest = Infinity;
  const value = valueAt(picture.x, px / width);
  curves.forEach((one, k) => {
    const [first, last] = picture.along ? [nearestIn(one.x, value, lengthOf(one)), -1] : (one.part ?? [0, lengthOf(one) - 1]);
    for (let i = first; i <= Math.max(last, first); i++) {
      const apart = far(one.x[i] as number, one.y[i] as number);
      if (apart < nearest) [curve, index, nearest] = [k, i, apart];
    }
  });
  return foundSample(picture, curve, index);
}

const rests = (picture: Picture, spot: Spot, dx: number, dy: number): Spot | undefined => {
  const { spots = [], cells } = picture;
  if (cells) return spots.find((one) => one.ix === (spot.ix ?? 0) + dx && one.iy === (spot.iy ?? 0) + dy);
  const along = (one: Spot): number => (dx ? dx * one.x : dy * one.y);
  let next: Spot | undefined;
  for (const one of spots) if (along(one) > along(spot) && (!next || along(one) < along(next))) next = one;
  return next;
};

/** What is next in a direction: a neighbouring cell or spot; the next sample, or the next curve up or down. */
export function stepFrom(picture: Picture, from: Found | null, [dx, dy]: [number, number]): Found | null {
  const { spots, curves } = picture;
  if (spots) {
    const next = from?.spot ? rests(picture, from.spot, Math.sign(dx), dy) : spots[0];
    return next ? foundSpot(picture, next) : null;
  }
  const curve = (((from?.curve ?? curves.length - 1) + dy) % curves.length + curves.length) % curves.length;
  const one = curves[curve];
  if (!one) return null;
  const [first, last] = one.part ?? [0, lengthOf(one) - 1];
  const start = from ? (dy && picture.along ? nearestIn(one.x, from.x, lengthOf(one)) : from.index) : first - dx;
  for (let index = start + dx; ; index += Math.sign(dx)) {
    const there = foundSample(picture, curve, Math.min(Math.max(index, first), last));
    if (there) return there;
    if (!dx || index <= first - 1 || index >= last + 1) return null;
  }
}
