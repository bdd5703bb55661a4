// Where a camera stands so that all points fill its frame, whatever the frame's shape.

import { Matrix4, Vector3, type PerspectiveCamera } from "three";
import { round } from "./motion.ts";

/** A place and how far around it something is drawn [m]. */
export type Spot = [at: Vector3, around: number];

/** Share of half a frame that is used, across and up. */
export type Room = [across: number, up: number];

/** The place from which all spots are seen along a direction, and the point in their midst. */
export function fitFrustum(spots: Spot[], towards: Vector3, up: Vector3, slopes: [number, number], room: Room): { eye: Vector3; target: Vector3; wide: number } {
  const basis = new Matrix4().lookAt(new Vector3(), towards, up);
  const back = basis.clone().transpose();
  const most = [-Infinity, -Infinity, -Infinity, -Infinity];
  let [near, far] = [-Infinity, Infinity];
  const [sx, sy] = [slopes[0] * room[0], slopes[1] * room[1]];
  const seen = new Vector3();
  for (const [at, around] of spots) {
    seen.copy(at).applyMatrix4(back);
    const sides = [seen.x + sx * seen.z, -seen.x + sx * seen.z, seen.y + sy * seen.z, -seen.y + sy * seen.z];
    sides.forEach((value, k) => (most[k] = Math.max(most[k] as number, value + around * Math.hypot(1, k < 2 ? sx : sy))));
    near = Math.max(near, seen.z + around);
    far = Math.min(far, seen.z - around);
  }
  const [right, left, above, below] = most as [number, number, number, number];
  const z = Math.max((right + left) / (2 * sx), (above + below) / (2 * sy), near + 1e-6);
  const [x, y] = [0.5 * (right - left), 0.5 * (above - below)];
  const eye = new Vector3(x, y, z).applyMatrix4(basis);
  const target = new Vector3(x, y, 0.5 * (near + far)).applyMatrix4(basis);
  return { eye, target, wide: z - 0.5 * (near + far) };
}

/** Put the camera there; gives the point that it looks at. */
export function placeCamera(camera: PerspectiveCamera, spots: Spot[], from: Vector3, room: Room, extent: number): Vector3 {
  const tall = Math.tan((camera.fov * Math.PI) / 360);
  const { eye, target, wide } = fitFrustum(spots, from.clone().negate(), camera.up, [tall * camera.aspect, tall], room);
  camera.position.copy(eye);
  camera.near = Math.max(0.02 * extent, 0.1 * (wide - extent));
  camera.far = wide + 30 * extent;
  camera.lookAt(target);
  camera.updateProjectionMatrix();
  return target;
}

/** Longest scale bar [px]. */
const BAR = 120;

/** Length [m] of a scale bar at a scale [px/m], and how long it is drawn [px]: 1, 2 or 5 of a power of ten. */
export function chooseBar(scale: number): [length: number, pixels: number] {
  const length = round(BAR / scale);
  return [length, length * scale];
}
