// Objects in space for shapes. An object is made once and put in place for every picture; bars, pins
// and balls share three geometries, and only coils and plates have vertices of their own to move.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, Group, Mesh, SphereGeometry, Vector3,
  type Material, type Object3D,
} from "three";
import type { Shape } from "../lib/types.ts";
import { Coil } from "./coil.ts";

/** What an object is put in place from. */
export interface Pose {
  shape: Shape;
  /** Points of the shape [m]. */
  at: (k: number) => Vector3;
  turn: number;
  slack: boolean;
  /** Size of the whole picture [m]: nothing is drawn so thin that it cannot be seen. */
  extent: number;
}

export interface Body {
  object: Object3D;
  put: (pose: Pose) => void;
  dispose?: () => void;
}

const ROUND = new CylinderGeometry(1, 1, 1, 20);
const BALL = new SphereGeometry(1, 20, 14);
const CUBE = new BoxGeometry(1, 1, 1);
const UP = new Vector3(0, 1, 0);
const THIN = { wire: 0.0032, tether: 0.002, link: 0.004 };
/** Pieces of the longest part of a wire, so that it can sag, and how far it does (of that part). */
const PIECES = 8;
const SAG = 0.05;

/** Put a cylinder between two points. */
function stretch(mesh: Mesh, first: Vector3, last: Vector3, radius: number): void {
  const way = last.clone().sub(first);
  const length = way.length();
  mesh.visible = length > 1e-9;
  mesh.position.copy(first).addScaledVector(way, 0.5);
  if (length > 0) mesh.quaternion.setFromUnitVectors(UP, way.multiplyScalar(1 / length));
  mesh.scale.set(radius, Math.max(length, 1e-9), radius);
}

/** A round bar through so many points. */
class Bar {
  readonly object = new Group();
  private readonly pieces: Mesh[] = [];
  private readonly knots: Mesh[] = [];

  constructor(count: number, material: Material) {
    for (let k = 0; k < count; k++) this.knots.push(new Mesh(BALL, material));
    for (let k = 1; k < count; k++) this.pieces.push(new Mesh(ROUND, material));
    this.object.add(...this.pieces, ...this.knots);
  }

  put(points: Vector3[], radius: number): void {
    this.knots.forEach((knot, k) => {
      knot.position.copy(points[k] as Vector3);
      knot.scale.setScalar(radius);
    });
    this.pieces.forEach((piece, k) => stretch(piece, points[k] as Vector3, points[k + 1] as Vector3, radius));
  }
}

const pointsOf = (pose: Pose): Vector3[] => Array.from({ length: pose.shape.count }, (_, k) => pose.at(k));

function bar(shape: Shape, material: Material, thin: number): Body {
  const made = new Bar(shape.count, material);
  return { object: made.object, put: (pose) => made.put(pointsOf(pose), Math.max(pose.shape.size, thin * pose.extent)) };
}

/** A pin: a bar with flat ends. */
function pin(material: Material): Body {
  const mesh = new Mesh(ROUND, material);
  return { object: mesh, put: ({ shape, at }) => stretch(mesh, at(0), at(1), shape.size) };
}

/** A wire: as thick as can be seen; thinner, and sagging, while it is slack. */
function wire(shape: Shape, material: Material): Body {
  const made = new Bar(shape.count + PIECES - 1, material);
  return {
    object: made.object,
    put: (pose) => {
      const radius = Math.max(0.5 * (pose.shape.diameter ?? 0), THIN.wire * pose.extent);
      made.put(sagging(pointsOf(pose), pose.slack ? SAG : 0), pose.slack ? 0.6 * radius : radius);
    },
  };
}

/** The points of a line, its longest part cut into pieces that hang down by a share of its length. */
function sagging(points: Vector3[], share: number): Vector3[] {
  let longest = 1;
  const reach = (k: number): number => (points[k] as Vector3).distanceTo(points[k - 1] as Vector3);
  for (let k = 2; k < points.length; k++) if (reach(k) > reach(longest)) longest = k;
  const [first, last] = [points[longest - 1] as Vector3, points[longest] as Vector3];
  const way = last.clone().sub(first);
  const upright = Math.abs(way.z) > 0.9 * way.length();
  const down = upright ? new Vector3(way.length(), 0, 0) : new Vector3(0, 0, -way.length());
  const inner = Array.from({ length: PIECES - 1 }, (_, k) => {
    const s = (k + 1) / PIECES;
    return first.clone().addScaledVector(way, s).addScaledVector(down, 4 * share * s * (1 - s));
  });
  return [...points.slice(0, longest), ...inner, ...points.slice(longest)];
}

/** A coil on the last part of a line, a thread on those before it. */
function coil(shape: Shape, material: Material, turns: number): Body {
  const lead = new Bar(shape.count - 1, material);
  const made = new Coil(turns, material);
  lead.object.add(made.mesh);
  return {
    object: lead.object,
    dispose: () => made.dispose(),
    put: (pose) => {
      const points = pointsOf(pose);
      const thin = THIN.tether * pose.extent;
      lead.put(points.slice(0, -1), shape.count > 2 ? thin : 0.5 * thin);
      const radius = Math.max(pose.shape.coil ? 0.5 * pose.shape.coil : pose.shape.size, 3 * thin);
      const wireRadius = Math.max(0.5 * (pose.shape.diameter ?? 0), thin);
      made.put(points.at(-2) as Vector3, points.at(-1) as Vector3, radius, wireRadius);
    },
  };
}

/** A cube that hangs at its point. */
function weight(material: Material): Body {
  const mesh = new Mesh(CUBE, material);
  return {
    object: mesh,
    put: ({ shape, at }) => {
      mesh.scale.setScalar(2 * shape.size);
      mesh.position.copy(at(0)).z -= shape.size;
    },
  };
}

function ball(material: Material): Body {
  const mesh = new Mesh(BALL, material);
  return {
    object: mesh,
    put: ({ shape, at }) => {
      mesh.scale.setScalar(shape.size);
      mesh.position.copy(at(0));
    },
  };
}

/** A disc with something on it that shows how far it is turned. */
function disc(shape: Shape, material: Material, mark: Material): Body {
  const group = new Group();
  const [plate, arm, end] = [new Mesh(ROUND, material), new Mesh(ROUND, mark), new Mesh(BALL, mark)];
  group.add(plate, arm, end);
  const rotor = shape.kind === "rotor";
  return {
    object: group,
    put: ({ shape: now, at, turn }) => {
      const [first, last] = [at(0), at(1)];
      const axis = last.clone().sub(first);
      const thick = axis.length();
      axis.multiplyScalar(1 / (thick || 1));
      stretch(plate, first, last, now.size);
      // an arm in front of the disc, from its axis on
      const reach = rotor ? at(2).sub(last) : across(axis).multiplyScalar(now.size);
      reach.applyAxisAngle(axis, turn);
      const centre = last.clone().addScaledVector(axis, 0.2 * thick);
      const tip = centre.clone().add(reach);
      stretch(arm, centre, tip, rotor ? 0.18 * now.size : 0.07 * now.size);
      end.position.copy(tip);
      end.scale.setScalar(rotor ? 0.6 * now.size : 0.09 * now.size);
    },
  };
}

/** A direction at a right angle to an axis: to the right, if that is one. */
function across(axis: Vector3): Vector3 {
  const right = Math.abs(axis.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 0, 1);
  return right.addScaledVector(axis, -right.dot(axis)).normalize();
}

/** A plate: a prism on its corners. */
function plate(shape: Shape, material: Material): Body {
  const n = shape.count;
  const geometry = new BufferGeometry();
  const places = new BufferAttribute(new Float32Array(6 * n), 3);
  const faces: number[] = [];
  for (let k = 1; k < n - 1; k++) faces.push(0, k, k + 1, n, n + k + 1, n + k);
  for (let k = 0; k < n; k++) {
    const next = (k + 1) % n;
    faces.push(k, n + k, next, next, n + k, n + next);
  }
  geometry.setAttribute("position", places);
  geometry.setIndex(faces);
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  return {
    object: mesh,
    dispose: () => geometry.dispose(),
    put: (pose) => {
      const points = pointsOf(pose);
      const [a, b, c] = points as [Vector3, Vector3, Vector3];
      const normal = b.clone().sub(a).cross(c.clone().sub(a)).normalize().multiplyScalar(pose.shape.size);
      points.forEach((point, k) => {
        places.setXYZ(k, point.x + normal.x, point.y + normal.y, point.z + normal.z);
        places.setXYZ(n + k, point.x - normal.x, point.y - normal.y, point.z - normal.z);
      });
      places.needsUpdate = true;
    },
  };
}

/** Turns of a spring that is no element. */
const TURNS = 11;
const MOST_TURNS = 40;

/** The object for a shape; `mark` is what shows turns. */
export function bodyOf(shape: Shape, material: Material, mark: Material): Body {
  switch (shape.kind) {
    case "wire":
      return shape.coil ? coil(shape, material, Math.min(Math.max(Math.round(shape.coils ?? TURNS), 2), MOST_TURNS)) : wire(shape, material);
    case "spring":
      return coil(shape, material, TURNS);
    case "joint":
      return pin(material);
    case "weight":
      return weight(material);
    case "object":
      return ball(material);
    case "pulley":
    case "rotor":
      return disc(shape, material, mark);
    case "plate":
      return plate(shape, material);
    case "tether":
      return bar(shape, material, THIN.tether);
    default:
      return bar(shape, material, THIN.link);
  }
}
