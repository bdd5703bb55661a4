// Plates, as rigid prisms with round corners, and strips that bend.

import { BufferAttribute, BufferGeometry, ExtrudeGeometry, Matrix4, Mesh, Shape as Outline, Sphere, Vector3, type Material } from "three";
import type { Shape } from "../lib/types.ts";
import type { Body } from "./bodies.ts";

/** How much of the shortest side a round corner takes. */
const ROUNDED = 0.14;
/** How far a plate reaches beyond its points, as a share of its shortest side. */
const BEYOND = 0.09;

/** A plate: made anew only if its sides get longer, moved as a whole otherwise. */
export function makePlate(material: Material): Body {
  const mesh = new Mesh(new BufferGeometry(), material);
  mesh.matrixAutoUpdate = false;
  let made = "";
  return {
    object: mesh,
    dispose: () => mesh.geometry.dispose(),
    put: ({ points, shape }) => {
      const [a, b, c] = points as [Vector3, Vector3, Vector3];
      const x = b.clone().sub(a).normalize();
      const normal = x.clone().cross(c.clone().sub(a)).normalize();
      const frame = new Matrix4().makeBasis(x, normal.clone().cross(x), normal).setPosition(a);
      const back = frame.clone().invert();
      const flat = points.map((point) => point.clone().applyMatrix4(back));
      const size = flat[1]?.x ?? 1;
      const key = flat.map(({ x, y }) => `${(x / size).toFixed(3)},${(y / size).toFixed(3)}`).join() + (shape.size / size).toFixed(3) + size.toPrecision(3);
      if (key !== made) {
        mesh.geometry.dispose();
        mesh.geometry = prism(flat, Math.max(shape.size, 1e-9));
        made = key;
      }
      mesh.matrix.copy(frame);
      mesh.matrixWorldNeedsUpdate = true;
    },
  };
}

function prism(points: Vector3[], half: number): BufferGeometry {
  const middle = points.reduce((sum, point) => sum.add(point), new Vector3()).divideScalar(points.length);
  // what is fixed to a corner is on the plate, not on its edge
  const shortest = Math.min(...points.map((point, k) => point.distanceTo(points[(k + 1) % points.length] as Vector3)));
  const corners = points.map((point) => point.clone().addScaledVector(point.clone().sub(middle).normalize(), BEYOND * shortest));
  const sides = corners.map((corner, k) => corner.distanceTo(corners[(k + 1) % corners.length] as Vector3));
  const round = ROUNDED * Math.min(...sides);
  const outline = new Outline();
  corners.forEach((corner, k) => {
    const towards = (other: Vector3): Vector3 => corner.clone().addScaledVector(other.clone().sub(corner).normalize(), round);
    const [into, out] = [towards(corners.at(k - 1) as Vector3), towards(corners[(k + 1) % corners.length] as Vector3)];
    if (k === 0) outline.moveTo(into.x, into.y);
    else outline.lineTo(into.x, into.y);
    outline.quadraticCurveTo(corner.x, corner.y, out.x, out.y);
  });
  outline.closePath();
  const bevel = 0.35 * half;
  const made = new ExtrudeGeometry(outline, {
    depth: 2 * (half - bevel), bevelEnabled: true, bevelThickness: bevel, bevelSize: bevel, bevelOffset: -bevel, bevelSegments: 2, curveSegments: 6,
  });
  return made.translate(0, 0, bevel - half);
}

/** Width of a strip across its plane, and its thickness, in radii of a bar. */
const [WIDE, THICK] = [7, 0.9];

/** A flat strip through its points, wide along y. */
export function makeStrip(shape: Shape, material: Material): Body {
  const n = shape.count;
  const geometry = new BufferGeometry();
  // four faces, each with corners of its own, so that edges are sharp
  const places = new BufferAttribute(new Float32Array(24 * n), 3);
  const normals = new BufferAttribute(new Float32Array(24 * n), 3);
  const faces: number[] = [];
  for (let face = 0; face < 4; face++) {
    for (let k = 0; k < n - 1; k++) {
      const a = 2 * (face * n + k);
      faces.push(a, a + 2, a + 1, a + 1, a + 2, a + 3);
    }
  }
  geometry.setAttribute("position", places);
  geometry.setAttribute("normal", normals);
  geometry.setIndex(faces);
  geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.userData.bends = true;
  const [way, up] = [new Vector3(), new Vector3()];
  const SIDES: [number, number][] = [[-1, 1], [1, 1], [1, -1], [-1, -1]];
  return {
    object: mesh,
    dispose: () => geometry.dispose(),
    put: ({ points, shape: now }) => {
      const [wide, thick] = [0.5 * WIDE * now.size, 0.5 * THICK * now.size];
      for (let k = 0; k < n; k++) {
        const at = points[k] as Vector3;
        way.copy(points[Math.min(k + 1, n - 1)] as Vector3).sub(points[Math.max(k - 1, 0)] as Vector3).normalize();
        up.set(-way.z, 0, way.x);
        for (let face = 0; face < 4; face++) {
          for (const corner of [0, 1]) {
            const [y, z] = SIDES[(face + corner) % 4] as [number, number];
            const index = 2 * (face * n + k) + corner;
            places.setXYZ(index, at.x + z * thick * up.x, at.y + y * wide, at.z + z * thick * up.z);
            const [ny, nz] = [[0, 1], [1, 0], [0, -1], [-1, 0]][face] as [number, number];
            normals.setXYZ(index, nz * up.x, ny, nz * up.z);
          }
        }
      }
      places.needsUpdate = true;
      normals.needsUpdate = true;
    },
  };
}
