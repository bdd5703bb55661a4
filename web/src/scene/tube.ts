// A round tube through points whose vertices are moved in place: wires, threads, coils.

import { BufferAttribute, BufferGeometry, Mesh, Sphere, Vector3, type Material } from "three";

const [way, side, up, next] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];

export class Tube {
  readonly mesh: Mesh;
  private readonly geometry = new BufferGeometry();
  private readonly places: BufferAttribute;
  private readonly normals: BufferAttribute;

  /** Rings at so many points, and one at either end that closes it. */
  constructor(
    private readonly count: number,
    material: Material,
    private readonly around = 8,
  ) {
    const vertices = (count + 2) * around;
    this.places = new BufferAttribute(new Float32Array(3 * vertices), 3);
    this.normals = new BufferAttribute(new Float32Array(3 * vertices), 3);
    const faces: number[] = [];
    for (let ring = 0; ring < count + 1; ring++) {
      for (let k = 0; k < around; k++) {
        const [a, b] = [ring * around + k, ring * around + ((k + 1) % around)];
        faces.push(a, b, a + around, b, b + around, a + around);
      }
    }
    this.geometry.setAttribute("position", this.places);
    this.geometry.setAttribute("normal", this.normals);
    this.geometry.setIndex(faces);
    this.geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
    this.mesh = new Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.userData.bends = true;
  }

  put(points: Vector3[], radius: number): void {
    const last = this.count - 1;
    side.set(0, 0, 0);
    for (let k = 0; k <= last; k++) {
      const at = points[k] as Vector3;
      way.copy(points[Math.min(k + 1, last)] as Vector3).sub(points[Math.max(k - 1, 0)] as Vector3);
      const length = way.length();
      if (length > 0) way.multiplyScalar(1 / length);
      else way.set(0, 0, 1);
      // the ring turns with the line, but not about it
      side.addScaledVector(way, -side.dot(way));
      if (side.lengthSq() < 1e-6) {
        side.set(Math.abs(way.y) < 0.9 ? 0 : 1, Math.abs(way.y) < 0.9 ? 1 : 0, 0);
        side.addScaledVector(way, -side.dot(way));
      }
      side.normalize();
      up.crossVectors(way, side);
      const wide = radius * miter(points, k, last);
      if (k === 0) this.ring(0, at, 0);
      this.ring(k + 1, at, wide);
      if (k === last) this.ring(k + 2, at, 0);
    }
    this.places.needsUpdate = true;
    this.normals.needsUpdate = true;
  }

  dispose(): void {
    this.geometry.dispose();
  }

  private ring(ring: number, at: Vector3, radius: number): void {
    const { around } = this;
    for (let k = 0; k < around; k++) {
      const angle = (2 * Math.PI * k) / around;
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      const [x, y, z] = [c * side.x + s * up.x, c * side.y + s * up.y, c * side.z + s * up.z];
      const place = ring * around + k;
      this.normals.setXYZ(place, x, y, z);
      this.places.setXYZ(place, at.x + radius * x, at.y + radius * y, at.z + radius * z);
    }
  }
}

/** How much wider a ring is where a line turns, so that the tube stays as thick; at most so much. */
function miter(points: Vector3[], k: number, last: number): number {
  if (k === 0 || k === last) return 1;
  next.copy(points[k + 1] as Vector3).sub(points[k] as Vector3);
  const cosine = next.dot(way) / (next.length() || 1);
  return 1 / Math.max(cosine, 0.75);
}

const [u, v] = [new Vector3(), new Vector3()];

/** Points of a helix between two points, with hooks that lead to both. */
export function windHelix(first: Vector3, last: Vector3, radius: number, turns: number, into: Vector3[]): void {
  way.copy(last).sub(first);
  const length = way.length() || 1e-12;
  way.multiplyScalar(1 / length);
  u.set(Math.abs(way.z) < 0.9 ? 0 : 1, 0, Math.abs(way.z) < 0.9 ? 1 : 0).addScaledVector(way, -u.dot(way));
  u.addScaledVector(way, -u.dot(way)).normalize();
  v.crossVectors(way, u);
  const rings = into.length;
  for (let ring = 0; ring < rings; ring++) {
    const end = ring === 0 || ring === rings - 1;
    const share = Math.min(Math.max((ring - 1) / (rings - 3), 0), 1);
    const angle = 2 * Math.PI * turns * share;
    const along = end ? (ring === 0 ? 0 : length) : length * (HOOK + (1 - 2 * HOOK) * share);
    const out = end ? 0 : radius;
    (into[ring] as Vector3)
      .copy(first)
      .addScaledVector(way, along)
      .addScaledVector(u, out * Math.cos(angle))
      .addScaledVector(v, out * Math.sin(angle));
  }
}

/** Share of the length that the hook at either end takes. */
const HOOK = 0.06;
