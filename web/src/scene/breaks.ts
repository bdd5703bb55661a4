// The marks at which a long part is drawn broken: a gap, with a slanted stroke at either side.

import { Group, Vector3, type Material, type Mesh } from "three";
import type { Shape } from "../lib/types.ts";
import { drawnAt, type Cut } from "./cuts.ts";
import { makeMesh, ROUND, stretchBar } from "./parts.ts";
import { drawnRadius } from "./wires.ts";

const TILT = new Vector3(0, 0.15, 0.5);

export class Break {
  readonly object = new Group();
  /** Middle of the gap [m]. */
  readonly at = new Vector3();
  private readonly gap: Mesh;
  private readonly strokes: Mesh[];
  private middle = 0;

  constructor(
    public cut: Cut,
    cuts: Cut[],
    back: Material,
    dark: Material,
  ) {
    this.gap = makeMesh(ROUND, back);
    this.strokes = [makeMesh(ROUND, dark), makeMesh(ROUND, dark)];
    this.object.add(this.gap, ...this.strokes);
    this.follow(cut, cuts);
  }

  /** Be the mark of another cut. */
  follow(cut: Cut, cuts: Cut[]): void {
    this.cut = cut;
    this.middle = drawnAt(cuts, cut.axis, 0.5 * (cut.low + cut.high));
  }

  /** Where a line, as it is drawn, goes over the cut; hidden if it does not. */
  put(shape: Shape, points: Vector3[], extent: number): void {
    const { axis } = this.cut;
    const on = (k: number): number => (points[k] as Vector3).getComponent(axis) - this.middle;
    let k = 1;
    while (k < points.length && on(k) * on(k - 1) > 0) k++;
    this.object.visible = k < points.length;
    if (!this.object.visible) return;
    const [first, last] = [points[k - 1] as Vector3, points[k] as Vector3];
    this.at.copy(first).lerp(last, on(k - 1) / (on(k - 1) - on(k)));
    const radius = shape.kind === "wire" ? drawnRadius(shape, extent) : Math.max(shape.size, 0.0015 * extent);
    const half = Math.min(0.008 * extent, 0.3 * this.cut.kept);
    const way = last.clone().sub(first).normalize();
    stretchBar(this.gap, this.at.clone().addScaledVector(way, -half), this.at.clone().addScaledVector(way, half), 1.06 * radius);
    const tall = 1.3 * radius + 0.006 * extent;
    const up = TILT.clone().addScaledVector(way, -TILT.dot(way)).normalize();
    if (axis === 2) up.set(1, 0, 0);
    this.strokes.forEach((stroke, side) => {
      const centre = this.at.clone().addScaledVector(way, side ? half : -half);
      const lean = up.clone().multiplyScalar(tall).addScaledVector(way, 0.4 * tall);
      stretchBar(stroke, centre.clone().sub(lean), centre.clone().add(lean), 0.0016 * extent);
    });
  }

}
