// The mechanism as a model that moves, glTF 2.0 in one binary file: rigid parts by their places, wires and
// coils by shapes between which they are blended. Colours are those at the time of the cursor.

import {
  AnimationClip, BufferAttribute, BufferGeometry, Group, Mesh, MeshLambertMaterial, MeshStandardMaterial, NumberKeyframeTrack, QuaternionKeyframeTrack, Quaternion,
  Vector3, VectorKeyframeTrack, type KeyframeTrack, type Object3D,
} from "three";
import { GLTFExporter } from "three/examples/jsm/exporters/GLTFExporter.js";
import type { Stage } from "./stage.ts";

/** Times at which the model is kept. */
const KEYS = 33;

interface Part {
  source: Mesh;
  copy: Mesh;
  places: number[];
  turns: number[];
  sizes: number[];
  /** Vertices at every time, of what bends. */
  bent: Float32Array[];
}

/** A model of what is on the stage, over the whole run in so many seconds. */
export async function exportModel(stage: Stage, seconds: number, now: number): Promise<Blob> {
  const { model } = stage;
  if (!model) throw new Error("There is no mechanism to save.");
  const { times } = model.motion.data;
  const keys = Array.from({ length: KEYS }, (_, k) => times[Math.round((k * (times.length - 1)) / (KEYS - 1))] ?? 0);
  const root = new Group();
  root.name = "mechanism";
  root.rotation.x = -0.5 * Math.PI; // glTF has y upwards
  const parts: Part[] = [];
  model.group.updateMatrixWorld(true);
  model.group.traverseVisible((one) => {
    if (one instanceof Mesh) parts.push(copied(one, nameOf(one, model.group, stage), parts.length, root));
  });
  for (const time of keys) {
    model.put(time);
    model.group.updateMatrixWorld(true);
    parts.forEach(keep);
  }
  model.put(now);
  const first = keys[0] ?? 0;
  const scale = seconds / ((keys.at(-1) ?? 1) - first || 1);
  const at = keys.map((time) => (time - first) * scale);
  const clip = new AnimationClip("run", seconds, parts.flatMap((part) => tracks(part, at)));
  try {
    const made = await new GLTFExporter().parseAsync(root, { binary: true, animations: [clip] });
    return new Blob([made as ArrayBuffer], { type: "model/gltf-binary" });
  } finally {
    parts.forEach(({ source, copy }) => source.geometry !== copy.geometry && copy.geometry.dispose());
  }
}

/** The name of the shape that a mesh is of. */
function nameOf(mesh: Mesh, group: Group, stage: Stage): string {
  let top: Object3D = mesh;
  while (top.parent && top.parent !== group) top = top.parent;
  return stage.nameOf(top) || "mark";
}

/** The paint of a picture without a graphics processor as glTF has it. */
const convertPaint = ({ color, opacity, transparent, side, vertexColors }: MeshLambertMaterial): MeshStandardMaterial =>
  new MeshStandardMaterial({ color, opacity, transparent, side, vertexColors, roughness: 0.8, metalness: 0 });

function copied(source: Mesh, name: string, count: number, root: Group): Part {
  const geometry: BufferGeometry = source.userData.bends ? source.geometry.clone() : source.geometry;
  const copy = new Mesh(geometry, source.material instanceof MeshLambertMaterial ? convertPaint(source.material) : source.material);
  copy.name = `${name} ${count}`.replaceAll(/[^\w]+/g, "_");
  root.add(copy);
  return { source, copy, places: [], turns: [], sizes: [], bent: [] };
}

const [place, turn, size] = [new Vector3(), new Quaternion(), new Vector3()];

function keep(part: Part): void {
  part.source.matrixWorld.decompose(place, turn, size);
  part.places.push(...place.toArray());
  part.turns.push(...turn.toArray());
  part.sizes.push(...size.toArray());
  if (part.source.userData.bends) part.bent.push(Float32Array.from(part.source.geometry.getAttribute("position").array));
}

/** Whether all rows of so many numbers are alike. */
const still = (values: number[], width: number): boolean => values.every((value, k) => Math.abs(value - (values[k % width] as number)) < 1e-9);

function tracks(part: Part, at: number[]): KeyframeTrack[] {
  const { copy, places, turns, sizes, bent } = part;
  copy.position.fromArray(places);
  copy.quaternion.fromArray(turns);
  copy.scale.fromArray(sizes);
  const found: KeyframeTrack[] = [];
  if (!still(places, 3)) found.push(new VectorKeyframeTrack(`${copy.name}.position`, at, places));
  if (!still(turns, 4)) found.push(new QuaternionKeyframeTrack(`${copy.name}.quaternion`, at, turns));
  if (!still(sizes, 3)) found.push(new VectorKeyframeTrack(`${copy.name}.scale`, at, sizes));
  const first = bent[0];
  if (!first) return found;
  copy.geometry.setAttribute("position", new BufferAttribute(first, 3));
  if (bent.every((row) => row.every((value, k) => Math.abs(value - (first[k] as number)) < 1e-9))) return found;
  copy.geometry.morphTargetsRelative = true;
  copy.geometry.morphAttributes.position = bent.slice(1).map((row) => new BufferAttribute(row.map((value, k) => value - (first[k] as number)), 3));
  copy.updateMorphTargets();
  const count = bent.length - 1;
  const shares = bent.flatMap((_, k) => Array.from({ length: count }, (_, i) => (i === k - 1 ? 1 : 0)));
  found.push(new NumberKeyframeTrack(`${copy.name}.morphTargetInfluences`, at, shares));
  return found;
}
