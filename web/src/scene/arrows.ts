// Forces as arrows: of elements on what they pull, and of weights, as long as they are large.

import { Group, Vector3, type Material } from "three";
import { makeArrow } from "./bodies.ts";
import type { Cast } from "./cast.ts";
import type { Word } from "./labels.ts";
import type { Reading } from "./stage.ts";

/** Length of the largest force, as a share of the picture. */
const LONGEST = 0.16;
const GRAVITY = 9.80665;

export class Arrows {
  readonly group = new Group();
  private readonly made: ReturnType<typeof makeArrow>[] = [];

  constructor(private readonly material: Material) {}

  hide(): Word[] {
    this.group.children.forEach((one) => (one.visible = false));
    return [];
  }

  /** Put them to where they are now; gives what is written beside them. */
  point(cast: Cast | null, reading: Reading | null): Word[] {
    this.hide();
    if (!cast || !reading) return [];
    const { shapes } = cast.motion.data;
    const heaviest = Math.max(reading.most, ...shapes.map((shape) => GRAVITY * (shape.mass ?? 0)));
    const { extent } = cast.motion;
    const long = (LONGEST * extent) / (heaviest || 1);
    const words: Word[] = [];
    shapes.forEach((shape, k) => {
      const points = cast.targets[k]?.points ?? [];
      const end = points.at(-1);
      if (!end) return;
      const force = shape.port === undefined ? GRAVITY * (shape.mass ?? 0) : reading.force(shape.port);
      if (force < 0.01 * heaviest) return;
      const way = shape.port === undefined ? new Vector3(0, 0, -1) : (points.at(-2) ?? end).clone().sub(end).normalize();
      const from = shape.port === undefined ? end.clone().add(new Vector3(0, 0, -2.3 * shape.size)) : end.clone();
      const to = from.clone().addScaledVector(way, long * force);
      this.next().point(from, to, 0.006 * extent);
      words.push({ text: `${Number(force.toPrecision(force < 100 ? 2 : 3))} N`, at: to, kind: "force", beside: Math.abs(way.z) > 0.9 });
    });
    return words;
  }

  private index(): number {
    const free = this.made.findIndex(({ object }) => !object.visible);
    return free < 0 ? this.made.length : free;
  }

  private next(): ReturnType<typeof makeArrow> {
    const k = this.index();
    const found = this.made[k] ?? makeArrow(this.material);
    if (k === this.made.length) {
      this.made.push(found);
      this.group.add(found.object);
    }
    return found;
  }
}
