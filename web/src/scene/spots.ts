// What a camera must see: points around everything, over the whole run.

import { Matrix4, Mesh, Vector3, type BufferAttribute } from "three";
import type { Spot } from "./camera.ts";
import type { Cast } from "./cast.ts";

/** Pictures of a run that are looked at. */
const LOOKS = 9;

/** Points around all that is drawn at some times of a run, which is left at the last one. */
export function spotsOf(cast: Cast): Spot[] {
  const found: Spot[] = [];
  const { times } = cast.motion.data;
  for (let k = 0; k < LOOKS; k++) {
    cast.put(times[Math.round((k * (times.length - 1)) / (LOOKS - 1))] ?? 0);
    cast.group.updateMatrixWorld(true);
    cast.group.traverseVisible((one) => one instanceof Mesh && found.push(...cornersOf(one)));
  }
  return found;
}

/** Corners of the box around spots [m]. */
export function boundsOf(spots: Spot[]): [low: number[], high: number[]] {
  const most = (sign: number): number[] => [0, 1, 2].map((axis) => sign * spots.reduce((a, [at]) => Math.max(a, sign * at.getComponent(axis)), -Infinity));
  return [most(-1), most(1)];
}

const corner = new Vector3();
const matrix = new Matrix4();

/** Points around a mesh: corners of its box as it is turned, or some of its own points if it bends. */
function cornersOf(mesh: Mesh): Spot[] {
  matrix.copy(mesh.matrixWorld);
  const places = mesh.geometry.getAttribute("position") as BufferAttribute;
  if (mesh.userData.bends) {
    const step = Math.max(2, Math.floor(places.count / 60) | 1);
    return Array.from({ length: Math.floor(places.count / step) }, (_, k): Spot => [new Vector3().fromBufferAttribute(places, k * step).applyMatrix4(matrix), 0]);
  }
  mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
  const box = mesh.geometry.boundingBox;
  if (!box) return [];
  return Array.from({ length: 8 }, (_, k): Spot => {
    corner.set(k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z);
    return [corner.clone().applyMatrix4(matrix), 0];
  });
}
