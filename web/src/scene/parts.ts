// Geometries that bodies share, all of unit size: a body scales and turns them into place.

import {
  BoxGeometry, ConeGeometry, CylinderGeometry, LatheGeometry, Mesh, SphereGeometry, TorusGeometry, Vector2, Vector3,
  type BufferGeometry, type Material,
} from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { RoundedBoxGeometry } from "three/examples/jsm/geometries/RoundedBoxGeometry.js";

const UP = new Vector3(0, 1, 0);

/** Radius 1, height 1, along y. */
export const ROUND = new CylinderGeometry(1, 1, 1, 24);
/** As `ROUND`, thinner at its upper end. */
export const TAPERED = new CylinderGeometry(0.84, 1, 1, 24);
export const BALL = new SphereGeometry(1, 24, 16);
export const CUBE = new BoxGeometry(1, 1, 1);
export const BLOCK = new RoundedBoxGeometry(2, 2, 2, 3, 0.25);
export const EYE = new TorusGeometry(1, 0.35, 8, 20);
export const CONE = new ConeGeometry(1, 1, 20);
/** A weight that hangs from 0 to -2: a hook, and a cylinder with rounded edges. */
export const WEIGHT = makeWeight();
/** A wheel of radius 1 and width 2 along y, in whose groove a wire lies; its hub and spokes, and one of these. */
export const RIM = lathe([[0.78, -0.7], [1.12, -0.8], [1.16, -0.65], [0.97, 0], [1.16, 0.65], [1.12, 0.8], [0.78, 0.7], [0.78, -0.7]]);
export const HUB = mergeGeometries([new CylinderGeometry(0.26, 0.26, 2.1, 20), ...spokes(1, 5)]) as BufferGeometry;
export const SPOKE = spokes(0, 1)[0] as BufferGeometry;
/** Housing of a motor of radius 1 and height 1. */
export const MOTOR = lathe([[0, -0.5], [0.9, -0.5], [1, -0.42], [1, -0.3], [0.94, -0.28], [0.94, 0.28], [1, 0.3], [1, 0.42], [0.9, 0.5], [0.3, 0.5], [0.3, 0.62], [0, 0.62]]);
/** A nut-like head of a pin, of radius 1 and height 1. */
export const HEAD = new CylinderGeometry(1, 1, 1, 6);

function lathe(profile: [number, number][]): BufferGeometry {
  return new LatheGeometry(profile.map(([x, y]) => new Vector2(x, y)), 36);
}

function spokes(from: number, until: number): BufferGeometry[] {
  return Array.from({ length: until - from }, (_, k) =>
    new BoxGeometry(0.62, 0.7, 0.14).translate(0.52, 0, 0).rotateY((2 * Math.PI * (k + from)) / 5),
  );
}

function makeWeight(): BufferGeometry {
  const body = new LatheGeometry(
    [[0, -2.3], [0.9, -2.3], [1, -2.2], [1, -0.72], [0.9, -0.62], [0.2, -0.58], [0.16, -0.5], [0.1, -0.4], [0, -0.38]].map(([x, y]) => new Vector2(x, y)),
    32,
  );
  const hook = new TorusGeometry(0.2, 0.06, 8, 20).translate(0, -0.2, 0);
  return mergeGeometries([body, hook]) as BufferGeometry;
}

/** Put something that reaches from -1/2 to 1/2 along y between two points, so thick. */
export function stretchBar(mesh: Mesh, first: Vector3, last: Vector3, radius: number): void {
  const way = last.clone().sub(first);
  const length = way.length();
  mesh.visible = length > 1e-9;
  mesh.position.copy(first).addScaledVector(way, 0.5);
  if (length > 0) mesh.quaternion.setFromUnitVectors(UP, way.multiplyScalar(1 / length));
  mesh.scale.set(radius, Math.max(length, 1e-9), radius);
}

/** A direction at a right angle to an axis: to the right, if that is one. */
export function findNormal(axis: Vector3): Vector3 {
  const right = Math.abs(axis.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 0, 1);
  return right.addScaledVector(axis, -right.dot(axis)).normalize();
}

export const makeMesh = (geometry: BufferGeometry, material: Material): Mesh => new Mesh(geometry, material);
