// One mechanism on the stage: its bodies, moved together to where they are at a time.

import { Group, Vector3, type Material } from "three";
import type { SceneData, Shape } from "../lib/types.ts";
import { bodyOf, type Body } from "./bodies.ts";
import { Break } from "./breaks.ts";
import type { Cut } from "./cuts.ts";
import type { Materials, Paint } from "./materials.ts";
import { Motion, structure } from "./motion.ts";
import type { Target } from "./pick.ts";
import type { Rgb } from "./tint.ts";

/** Kinds of shapes that can be drawn broken. */
const LINES = ["wire", "tether", "ground", "link", "phalanx", "fingertip"];

const built = (data: SceneData, cuts: Cut[]): string => [structure(data.shapes), ...cuts.map((cut) => cut.axis)].join();

let casts = 0;

export class Cast {
  /** Tells it from others. */
  readonly id = ++casts;
  readonly group = new Group();
  readonly targets: Target[] = [];
  breaks: { mark: Break; shape: number }[] = [];
  motion: Motion;
  private bodies: Body[] = [];
  private readonly paints = new Map<string, Paint>();
  private readonly built: string;

  /** `ghost` is what all of it is made of, if it is one. */
  constructor(
    data: SceneData,
    cuts: Cut[],
    materials: Materials,
    private readonly ghost: Material | null = null,
  ) {
    this.motion = new Motion(data, cuts);
    this.built = built(data, cuts);
    for (const shape of data.shapes) this.add(shape, materials);
    if (ghost) return;
    this.breaks = data.shapes.flatMap((shape, k) =>
      LINES.includes(shape.kind) && !shape.coil
        ? cuts.map((cut) => ({ mark: new Break(cut, cuts, materials.back, materials.made.dark), shape: k }))
        : [],
    );
    for (const { mark } of this.breaks) this.group.add(mark.object);
  }

  /** Go on with another run of the same structure; whether that can be done. */
  follow(data: SceneData, cuts: Cut[]): boolean {
    if (built(data, cuts) !== this.built) return false;
    this.motion = new Motion(data, cuts);
    this.breaks.forEach(({ mark }, k) => mark.follow(cuts[k % cuts.length] as Cut, cuts));
    return true;
  }

  /** Number of elements. */
  get wires(): number {
    return this.paints.size;
  }

  put(time: number, colour?: (port: string) => Rgb): void {
    const { motion } = this;
    motion.at(time);
    const { extent } = motion;
    motion.data.shapes.forEach((shape, k) => {
      const points = this.targets[k]?.points ?? [];
      points.forEach((point, i) => point.fromArray(motion.places, (motion.starts[k] ?? 0) + 3 * i));
      const slack = shape.port !== undefined && motion.slack(shape.port, time);
      this.bodies[k]?.put({ shape, points, turn: motion.turns[k] ?? 0, slack, extent });
      const material = shape.port === undefined ? undefined : this.paints.get(shape.port);
      if (!material || !colour || shape.port === undefined) return;
      const [r, g, b] = colour(shape.port);
      material.color.setRGB(r / 255, g / 255, b / 255, "srgb");
    });
    for (const { mark, shape } of this.breaks) mark.put(motion.data.shapes[shape] as Shape, this.targets[shape]?.points ?? [], extent);
  }

  dispose(): void {
    this.bodies.forEach((body) => body.dispose?.());
    this.paints.forEach((material) => material.dispose());
    this.group.removeFromParent();
  }

  private add(shape: Shape, materials: Materials): void {
    let own: Material = this.ghost ?? materials.made.thread;
    if (shape.port !== undefined && !this.ghost) {
      const made = materials.make(0.45);
      this.paints.set(shape.port, made);
      own = made;
    }
    const body = bodyOf(shape, (made) => this.ghost ?? materials.made[made], own);
    const points = Array.from({ length: shape.count }, () => new Vector3());
    this.bodies.push(body);
    this.targets.push({ name: shape.name, object: body.object, points });
    this.group.add(body.object);
  }
}
