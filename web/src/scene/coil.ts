// A helix of round wire between two points, with hooks at its ends; its vertices are moved in place.

import { BufferAttribute, BufferGeometry, Mesh, Vector3, type Material } from "three";

const PER_TURN = 14;
const AROUND = 6;
/** Share of the length that the hook at either end takes. */
const HOOK = 0.06;

export class Coil {
  readonly mesh: Mesh;
  private readonly geometry = new BufferGeometry();
  private readonly places: BufferAttribute;
  private readonly normals: BufferAttribute;
  private readonly rings: number;

  constructor(private readonly turns: number, material: Material) {
    this.rings = turns * PER_TURN + 3;
    const vertices = this.rings * AROUND;
    this.places = new BufferAttribute(new Float32Array(3 * vertices), 3);
    this.normals = new BufferAttribute(new Float32Array(3 * vertices), 3);
    const faces: number[] = [];
    for (let ring = 0; ring < this.rings - 1; ring++) {
      for (let k = 0; k < AROUND; k++) {
        const [a, b] = [ring * AROUND + k, ring * AROUND + ((k + 1) % AROUND)];
        faces.push(a, b, a + AROUND, b, b + AROUND, a + AROUND);
      }
    }
    this.geometry.setAttribute("position", this.places);
    this.geometry.setAttribute("normal", this.normals);
    this.geometry.setIndex(faces);
    this.mesh = new Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
  }

  put(first: Vector3, last: Vector3, radius: number, wire: number): void {
    const axis = last.clone().sub(first);
    const length = axis.length();
    this.mesh.visible = length > 1e-9;
    if (length <= 1e-9) return;
    axis.multiplyScalar(1 / length);
    const u = Math.abs(axis.z) < 0.9 ? new Vector3(0, 0, 1) : new Vector3(1, 0, 0);
    u.addScaledVector(axis, -u.dot(axis)).normalize();
    const v = axis.clone().cross(u);
    const [spot, out, side] = [new Vector3(), new Vector3(), new Vector3()];
    for (let ring = 0; ring < this.rings; ring++) {
      const end = ring === 0 || ring === this.rings - 1;
      const share = Math.min(Math.max((ring - 1) / (this.rings - 3), 0), 1);
      const angle = 2 * Math.PI * this.turns * share;
      out.copy(u).multiplyScalar(Math.cos(angle)).addScaledVector(v, Math.sin(angle));
      const along = end ? (ring === 0 ? 0 : length) : length * (HOOK + (1 - 2 * HOOK) * share);
      spot.copy(first).addScaledVector(axis, along).addScaledVector(out, end ? 0 : radius);
      side.copy(axis);
      this.ring(ring, spot, out, side, wire);
    }
    this.places.needsUpdate = true;
    this.normals.needsUpdate = true;
  }

  dispose(): void {
    this.geometry.dispose();
  }

  /** One ring of vertices around the wire, in the plane of the axis and of what points outwards. */
  private ring(ring: number, spot: Vector3, out: Vector3, side: Vector3, wire: number): void {
    for (let k = 0; k < AROUND; k++) {
      const [c, s] = [Math.cos((2 * Math.PI * k) / AROUND), Math.sin((2 * Math.PI * k) / AROUND)];
      const [x, y, z] = [c * out.x + s * side.x, c * out.y + s * side.y, c * out.z + s * side.z];
      const place = ring * AROUND + k;
      this.normals.setXYZ(place, x, y, z);
      this.places.setXYZ(place, spot.x + wire * x, spot.y + wire * y, spot.z + wire * z);
    }
  }
}
