// Lines: wires with crimps at their ends, which sag while they are slack, threads, and coils.

import { Group, Vector3, type Material } from "three";
import type { Shape } from "../lib/types.ts";
import type { Body, Pose } from "./bodies.ts";
import { makeMesh, ROUND, stretchBar } from "./parts.ts";
import { Tube, windHelix } from "./tube.ts";

/** Least radius of a line, as a share of the picture. */
const THIN = { wire: 0.0042, thread: 0.0015 };
/** Pieces of the longest part of a wire, so that it can sag, and how far it does (of that part). */
const PIECES = 8;
const SAG = 0.05;
const PER_TURN = 16;

/** The radius that a wire is drawn with [m]: its own, or so much that it can be seen. */
export const drawnRadius = (shape: Shape, extent: number): number => Math.max(0.5 * (shape.diameter ?? 0), THIN.wire * extent);

export function makeWire(shape: Shape, material: Material, metal: Material): Body {
  const tube = new Tube(shape.count + PIECES - 1, material);
  const crimps = [makeMesh(ROUND, metal), makeMesh(ROUND, metal)];
  const object = new Group();
  object.add(tube.mesh, ...crimps);
  const row = Array.from({ length: shape.count + PIECES - 1 }, () => new Vector3());
  return {
    object,
    dispose: () => tube.dispose(),
    put: (pose) => {
      const radius = drawnRadius(pose.shape, pose.extent);
      sag(pose.points, pose.slack ? SAG : 0, row);
      tube.put(row, pose.slack ? 0.7 * radius : radius);
      crimp(crimps[0], pose.points[0], pose.points[1], radius);
      crimp(crimps[1], pose.points.at(-1), pose.points.at(-2), radius);
    },
  };
}

/** A sleeve on the end of a wire. */
function crimp(mesh: ReturnType<typeof makeMesh> | undefined, end?: Vector3, inner?: Vector3, radius = 0): void {
  if (!mesh || !end || !inner) return;
  const length = Math.min(7 * radius, 0.4 * end.distanceTo(inner));
  stretchBar(mesh, end, end.clone().lerp(inner, length / (end.distanceTo(inner) || 1)), 2.2 * radius);
}

/** The points of a line, its longest part cut into pieces that hang down by a share of its length. */
function sag(points: Vector3[], share: number, row: Vector3[]): void {
  let longest = 1;
  const reach = (k: number): number => (points[k] as Vector3).distanceTo(points[k - 1] as Vector3);
  for (let k = 2; k < points.length; k++) if (reach(k) > reach(longest)) longest = k;
  const [first, last] = [points[longest - 1] as Vector3, points[longest] as Vector3];
  const length = reach(longest);
  const upright = Math.abs(last.z - first.z) > 0.9 * length;
  row.forEach((spot, k) => {
    const inner = k - longest + 1;
    if (inner <= 0) spot.copy(points[k] as Vector3);
    else if (inner >= PIECES) spot.copy(points[k - PIECES + 1] as Vector3);
    else {
      const s = inner / PIECES;
      spot.copy(first).lerp(last, s);
      const down = 4 * share * s * (1 - s) * length;
      if (upright) spot.x += down;
      else spot.z -= down;
    }
  });
}

export function makeThread(shape: Shape, material: Material): Body {
  const tube = new Tube(shape.count, material, 6);
  return {
    object: tube.mesh,
    dispose: () => tube.dispose(),
    put: (pose) => tube.put(pose.points, Math.max(pose.shape.size, THIN.thread * pose.extent)),
  };
}

/** A coil on the last part of a line, a thread on those before it. */
export function makeCoil(shape: Shape, material: Material, turns: number): Body {
  const leads = shape.count > 2 ? new Tube(shape.count - 1, material, 6) : null;
  const row = Array.from({ length: turns * PER_TURN + 3 }, () => new Vector3());
  const helix = new Tube(row.length, material, 8);
  const object = new Group();
  object.add(helix.mesh);
  if (leads) object.add(leads.mesh);
  return {
    object,
    dispose: () => [helix, leads].forEach((one) => one?.dispose()),
    put: (pose: Pose) => {
      const [first, last] = [pose.points.at(-2) as Vector3, pose.points.at(-1) as Vector3];
      const thin = THIN.wire * 0.55 * pose.extent;
      const radius = Math.max(pose.shape.coil ? 0.5 * pose.shape.coil : pose.shape.size, 4 * thin);
      // turns that lie on each other are as thick as there is room for
      const most = (0.42 * first.distanceTo(last)) / turns;
      const thick = Math.min(Math.max(0.5 * (pose.shape.diameter ?? 0), thin), Math.max(most, 0.5 * thin));
      leads?.put(pose.points.slice(0, -1), THIN.thread * pose.extent);
      windHelix(first, last, radius, turns, row);
      helix.put(row, thick);
    },
  };
}
