// Objects in space for shapes. An object is made once and put in place for every picture; what is
// rigid shares a few geometries, and only lines, coils and strips have vertices of their own to move.

import { Group, Matrix4, Mesh, Vector3, type Material, type Object3D } from "three";
import type { Kind, Shape } from "../lib/types.ts";
import type { Made } from "./materials.ts";
import { findNormal, BALL, BLOCK, CONE, CUBE, EYE, HEAD, HUB, MOTOR, makeMesh, RIM, ROUND, SPOKE, stretchBar, TAPERED, WEIGHT } from "./parts.ts";
import { makePlate, makeStrip } from "./sheets.ts";
import { makeCoil, makeThread, makeWire } from "./wires.ts";

/** What an object is put in place from. */
export interface Pose {
  shape: Shape;
  /** Points of the shape [m]. */
  points: Vector3[];
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

/** What a material is asked for by; of a ghost all are the same. */
export type Taken = (made: Made) => Material;

const THIN = 0.004;
const Y = new Vector3(0, 1, 0);
const [first, last] = [(pose: Pose): Vector3 => pose.points[0] as Vector3, (pose: Pose): Vector3 => pose.points.at(-1) as Vector3];

function grouped(...parts: Object3D[]): Group {
  const group = new Group();
  group.add(...parts);
  return group;
}

/** A round bar through so many points; with eyes at its ends, if it is a link. */
function bar(shape: Shape, material: Material, eyes: boolean): Body {
  const pieces = Array.from({ length: shape.count - 1 }, () => makeMesh(ROUND, material));
  const knots = Array.from({ length: shape.count }, () => makeMesh(eyes ? ROUND : BALL, material));
  return {
    object: grouped(...pieces, ...knots),
    put: (pose) => {
      const radius = Math.max(pose.shape.size, THIN * pose.extent);
      pieces.forEach((piece, k) => stretchBar(piece, pose.points[k] as Vector3, pose.points[k + 1] as Vector3, radius));
      knots.forEach((knot, k) => {
        knot.position.copy(pose.points[k] as Vector3);
        knot.scale.setScalar(radius).multiplyScalar(eyes ? 1.7 : 1);
        if (eyes) knot.scale.y = 2.4 * radius;
      });
    },
  };
}

/** A finger's link: round, thinner towards its end; the last one has a soft tip. */
function phalanx(taken: Taken, soft: Made): Body {
  const [bone, knuckle, pad, tip] = [makeMesh(TAPERED, taken("bone")), makeMesh(BALL, taken("bone")), makeMesh(ROUND, taken(soft)), makeMesh(BALL, taken(soft))];
  return {
    object: grouped(bone, knuckle, pad, tip),
    put: (pose) => {
      const { size } = pose.shape;
      const [from, to] = [first(pose), last(pose)];
      const length = from.distanceTo(to) || 1;
      stretchBar(bone, from, to, size);
      knuckle.position.copy(from);
      knuckle.scale.setScalar(size);
      pad.visible = soft !== "bone";
      stretchBar(pad, from.clone().lerp(to, 1 - Math.min(0.22, (1.5 * size) / length)), to, 0.88 * size);
      tip.position.copy(to);
      tip.scale.setScalar(0.88 * size);
    },
  };
}

/** A post with an eye at its end, whose axis is along the wire that slides through. */
function bracket(taken: Taken): Body {
  const [post, eye] = [makeMesh(ROUND, taken("steel")), makeMesh(EYE, taken("steel"))];
  return {
    object: grouped(post, eye),
    put: (pose) => {
      const [from, to] = [first(pose), last(pose)];
      const radius = Math.max(pose.shape.size, 0.5 * THIN * pose.extent);
      stretchBar(post, from, to, radius);
      const up = to.clone().sub(from).normalize();
      const through = up.clone().cross(Y);
      eye.quaternion.setFromRotationMatrix(new Matrix4().makeBasis(Y, up, through.negate()));
      eye.position.copy(to);
      eye.scale.setScalar(1.6 * radius);
    },
  };
}

/** A slab along its points, as deep as is usual for what is fixed to it. */
function wall(shape: Shape, material: Material): Body {
  const pieces = Array.from({ length: shape.count - 1 }, () => makeMesh(CUBE, material));
  return {
    object: grouped(...pieces),
    put: (pose) =>
      pieces.forEach((piece, k) => {
        const [from, to] = [pose.points[k] as Vector3, pose.points[k + 1] as Vector3];
        stretchBar(piece, from, to, 1);
        const thick = Math.max(2 * pose.shape.size, 2 * THIN * pose.extent);
        piece.scale.x = thick;
        piece.scale.z = Math.max(0.6 * from.distanceTo(to), 3 * thick);
        // `stretch` turns about an axis at a right angle to y, so what was z stays level only in this plane
        const way = to.clone().sub(from).normalize();
        if (Math.abs(way.y) < 0.9) piece.quaternion.setFromRotationMatrix(new Matrix4().makeBasis(way.clone().cross(Y), way, Y));
      }),
  };
}

/** A pin, from side to side, with a head at either end. */
function pin(taken: Taken): Body {
  const [shaft, near, far] = [makeMesh(ROUND, taken("dark")), makeMesh(HEAD, taken("steel")), makeMesh(HEAD, taken("steel"))];
  return {
    object: grouped(shaft, near, far),
    put: (pose) => {
      const [from, to] = [first(pose), last(pose)];
      const { size } = pose.shape;
      stretchBar(shaft, from, to, size);
      const head = to.clone().sub(from).multiplyScalar(0.06);
      stretchBar(near, from, from.clone().sub(head), 0.62 * size);
      stretchBar(far, to, to.clone().add(head), 0.62 * size);
    },
  };
}

function weight(material: Material): Body {
  const mesh = makeMesh(WEIGHT, material);
  mesh.rotation.x = 0.5 * Math.PI;
  return {
    object: mesh,
    put: (pose) => {
      mesh.scale.setScalar(pose.shape.size);
      mesh.position.copy(first(pose));
    },
  };
}

/** One part of a size around a point. */
function around(mesh: Mesh, share: number): Body {
  return {
    object: mesh,
    put: (pose) => {
      mesh.scale.setScalar(share * pose.shape.size);
      mesh.position.copy(first(pose));
    },
  };
}

/** A wheel with a groove, and one spoke of another colour that shows how far it is turned. */
function wheel(taken: Taken): Body {
  const turning = grouped(makeMesh(RIM, taken("wheel")), makeMesh(HUB, taken("wheel")), makeMesh(SPOKE, taken("rotor")));
  return {
    object: turning,
    put: (pose) => {
      const [from, to] = [first(pose), last(pose)];
      const axis = to.clone().sub(from);
      const thick = Math.max(axis.length(), 0.5 * pose.shape.size);
      axis.normalize();
      turning.position.copy(from).lerp(to, 0.5);
      const x = findNormal(axis).applyAxisAngle(axis, pose.turn);
      turning.quaternion.setFromRotationMatrix(new Matrix4().makeBasis(x, axis, x.clone().cross(axis)));
      turning.scale.set(pose.shape.size, 0.5 * thick, pose.shape.size);
    },
  };
}

/** A hub with an arm and a mass at its end. */
function rotor(taken: Taken): Body {
  const [hub, arm, mass] = [makeMesh(ROUND, taken("steel")), makeMesh(CUBE, taken("rotor")), makeMesh(ROUND, taken("rotor"))];
  return {
    object: grouped(hub, arm, mass),
    put: (pose) => {
      const [from, to] = [first(pose), pose.points[1] as Vector3];
      const { size } = pose.shape;
      const axis = to.clone().sub(from).normalize();
      const reach = last(pose).clone().sub(to).applyAxisAngle(axis, pose.turn);
      stretchBar(hub, from, to, 0.55 * size);
      const centre = from.clone().lerp(to, 0.6);
      const tip = centre.clone().add(reach);
      stretchBar(mass, tip.clone().addScaledVector(axis, -0.6 * size), tip.clone().addScaledVector(axis, 0.6 * size), 0.9 * size);
      const length = reach.length() || 1e-9;
      const along = reach.clone().multiplyScalar(1 / length);
      arm.position.copy(centre).addScaledVector(reach, 0.5);
      arm.quaternion.setFromRotationMatrix(new Matrix4().makeBasis(along.clone().cross(axis), along, axis));
      arm.scale.set(0.6 * size, length, 0.35 * size);
    },
  };
}

/** One part from the first point to the second. */
function between(mesh: Mesh): Body {
  return { object: mesh, put: (pose) => stretchBar(mesh, first(pose), last(pose), pose.shape.size) };
}

/** An arrow of a thickness that goes with the whole picture. */
export function makeArrow(material: Material): { object: Group; point: (from: Vector3, to: Vector3, thick: number) => void } {
  const [shaft, head] = [makeMesh(ROUND, material), makeMesh(CONE, material)];
  const object = grouped(shaft, head);
  return {
    object,
    point: (from, to, thick) => {
      const length = from.distanceTo(to);
      object.visible = length > 0.5 * thick;
      const neck = to.clone().lerp(from, Math.min((5 * thick) / (length || 1), 0.6));
      stretchBar(shaft, from, neck, thick);
      stretchBar(head, neck, to, 2.4 * thick);
    },
  };
}

function force(material: Material): Body {
  const { object, point } = makeArrow(material);
  return { object, put: (pose) => point(first(pose), last(pose), 0.006 * pose.extent) };
}

/** Turns of a spring that is no element. */
const TURNS = 11;
const MOST_TURNS = 40;

type Maker = (shape: Shape, taken: Taken, own: Material) => Body;

const MAKERS: Record<Kind, Maker> = {
  ground: (shape, taken) => bar(shape, taken("frame"), false),
  wall: (shape, taken) => wall(shape, taken("wall")),
  link: (shape, taken) => bar(shape, taken("link"), true),
  phalanx: (_, taken) => phalanx(taken, "bone"),
  fingertip: (_, taken) => phalanx(taken, "pad"),
  beam: (shape, taken) => makeStrip(shape, taken("link")),
  bracket: (_, taken) => bracket(taken),
  joint: (_, taken) => pin(taken),
  wire: (shape, taken, own) =>
    shape.coil ? makeCoil(shape, own, Math.min(Math.max(Math.round(shape.coils ?? TURNS), 2), MOST_TURNS)) : makeWire(shape, own, taken("steel")),
  spring: (shape, taken) => makeCoil(shape, taken("spring"), TURNS),
  tether: (shape, taken) => makeThread(shape, taken("thread")),
  force: (_, taken) => force(taken("force")),
  weight: (_, taken) => weight(taken("weight")),
  slider: (_, taken) => around(makeMesh(BLOCK, taken("dark")), 1),
  object: (_, taken) => around(makeMesh(BALL, taken("dark")), 1),
  pulley: (_, taken) => wheel(taken),
  cylinder: (_, taken) => between(makeMesh(ROUND, taken("gripped"))),
  motor: (_, taken) => between(makeMesh(MOTOR, taken("dark"))),
  plate: (_, taken) => makePlate(taken("plate")),
  palm: (_, taken) => makePlate(taken("bone")),
  rotor: (_, taken) => rotor(taken),
};

/** The object for a shape; `own` is the material of an element, whose colour changes. */
export const bodyOf = (shape: Shape, taken: Taken, own: Material): Body => (MAKERS[shape.kind] ?? MAKERS.ground)(shape, taken, own);
