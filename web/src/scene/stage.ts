// The mechanism in space, by WebGL. Renders when something has changed and never otherwise.

import {
  AmbientLight, Color, DirectionalLight, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Scene, Vector3, WebGLRenderer, BufferAttribute, BufferGeometry, SphereGeometry,
  CylinderGeometry,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Kind, SceneData } from "../lib/types.ts";
import { bodyOf, type Body } from "./bodies.ts";
import { Motion, round, structure } from "./motion.ts";
import type { Rgb } from "./tint.ts";

export interface Colours {
  back: string;
  ink: string;
  soft: string;
  line: string;
  spring: string;
  weight: string;
  rotor: string;
}

export type View = "free" | "front" | "side" | "top";

const EYES: Record<View, [number, number, number]> = {
  free: [0.3, -1, 0.32], front: [0, -1, 0], side: [1, 0, 0], top: [0, -0.001, 1],
};
/** How far in front of everything, and below it, the scale lies (of the extent). */
const SCALE_AT: [number, number, number] = [0, 0.07, 0.03];
const CELLS = 20;
const FIELD = 32;
const TURN = 0.12;
const NEARER = 0.88;

/** Asked of WebGL. Where a processor has to draw, edges are not smoothed, which costs it most. */
const LOOKS = { alpha: true, antialias: true, powerPreference: "low-power" } as const;

export class Stage {
  /** Pictures that were rendered. */
  rendered = 0;
  /** Length of a square of the grid, and of the scale [m]. */
  step = 0;
  motion: Motion | null = null;

  private readonly renderer: WebGLRenderer;
  private readonly world = new Scene();
  private readonly camera = new PerspectiveCamera(FIELD, 1, 0.01, 10);
  private readonly controls: OrbitControls;
  private readonly lamp = new DirectionalLight(0xffffff, 2.2);
  private readonly materials: Record<"ground" | "link" | "joint" | "spring" | "weight" | "rotor" | "tether", MeshLambertMaterial>;
  private readonly wires = new Map<string, MeshLambertMaterial>();
  private readonly grid: LineSegments<BufferGeometry, LineBasicMaterial>;
  private readonly scale: Mesh[];
  private readonly group = new Group();
  private bodies: Body[] = [];
  private built = "";
  private fitted = "";
  private touched = false;
  private waiting = 0;
  private time = 0;
  private readonly spots: Vector3[] = [];

  constructor(
    private readonly host: HTMLElement,
    private readonly label: HTMLElement,
  ) {
    const canvas = document.createElement("canvas");
    const quick = canvas.getContext("webgl2", { ...LOOKS, failIfMajorPerformanceCaveat: true });
    this.renderer = new WebGLRenderer(quick ? { canvas, context: quick } : { ...LOOKS, canvas, antialias: false });
    this.renderer.setPixelRatio(quick ? Math.min(devicePixelRatio, 2) : 1);
    canvas.setAttribute("aria-hidden", "true");
    host.prepend(canvas);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.soon());
    this.controls.addEventListener("start", () => (this.touched = true));
    const made = (): MeshLambertMaterial => new MeshLambertMaterial();
    this.materials = {
      ground: made(), link: made(), joint: made(), spring: made(), weight: made(), rotor: made(), tether: made(),
    };
    this.grid = squares();
    const bar = new CylinderGeometry(1, 1, 1, 8);
    const end = new SphereGeometry(1, 8, 6);
    this.scale = [bar, end, end].map((shape) => new Mesh(shape, this.materials.joint));
    this.world.add(new AmbientLight(0xffffff, 1.5), this.camera, this.group, this.grid, ...this.scale);
    this.camera.add(this.lamp, this.lamp.target);
    this.lamp.position.set(-0.6, 0.9, 0.6);
    this.lamp.target.position.set(0, 0, -1);
    this.resize();
  }

  /** Show a run; its shapes are those of the last one if they have the same structure. */
  show(data: SceneData): void {
    this.motion = new Motion(data);
    const now = structure(data.shapes);
    if (now !== this.built) this.build(data);
    this.built = now;
    const box = [...data.low, ...data.high].map((x) => (x / (this.motion?.extent ?? 1)).toFixed(1)).join();
    const where = `${now} ${box} ${this.motion.extent.toPrecision(2)}`;
    if (where !== this.fitted && !(this.touched && this.fitted.startsWith(now))) this.fit();
    this.fitted = where;
    this.ground(data);
  }

  /** Put everything to where it is at a time [s], in the colours of the elements there. */
  put(time: number, colour: (port: string) => Rgb): void {
    this.time = time;
    const motion = this.motion;
    if (!motion) return;
    motion.at(time);
    motion.data.shapes.forEach((shape, k) => {
      const start = motion.starts[k] ?? 0;
      const slack = shape.port !== undefined && motion.slack(shape.port, time);
      const at = (point: number): Vector3 => new Vector3().fromArray(motion.places, start + 3 * point);
      this.bodies[k]?.put({ shape, at, turn: motion.turns[k] ?? 0, slack, extent: motion.extent });
      if (shape.port !== undefined) {
        const [r, g, b] = colour(shape.port);
        this.wires.get(shape.port)?.color.setRGB(r / 255, g / 255, b / 255, "srgb");
      }
    });
    this.soon();
  }

  paint(colours: Colours): void {
    const { ground, link, joint, spring, weight, rotor, tether } = this.materials;
    ground.color.set(colours.soft).lerp(new Color(colours.back), 0.55);
    link.color.set(colours.soft).lerp(new Color(colours.back), 0.15);
    joint.color.set(colours.ink).lerp(new Color(colours.back), 0.25);
    tether.color.set(colours.soft);
    spring.color.set(colours.spring);
    weight.color.set(colours.weight);
    rotor.color.set(colours.rotor);
    this.grid.material.color.set(colours.line);
    this.soon();
  }

  /** Look at the whole motion. */
  fit(view: View = "free"): void {
    const data = this.motion?.data;
    if (!data) return;
    const eye = new Vector3(...EYES[view]).normalize();
    const middle = new Vector3(...data.low).add(new Vector3(...data.high)).multiplyScalar(0.5);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).add(eye);
    this.camera.lookAt(middle);
    this.camera.updateMatrixWorld();
    const back = this.camera.matrixWorldInverse.clone().setPosition(0, 0, 0);
    const tall = Math.tan((FIELD * Math.PI) / 360);
    const extent = this.motion?.extent ?? 1;
    let far = 0;
    for (let corner = 0; corner < 8; corner++) {
      const pick = (k: 0 | 1 | 2): number => ((corner >> k) & 1 ? data.high[k] : data.low[k] - (SCALE_AT[k] ?? 0) * extent);
      const seen = new Vector3(pick(0), pick(1), pick(2)).sub(middle).applyMatrix4(back);
      far = Math.max(far, Math.max(Math.abs(seen.x) / (tall * this.camera.aspect), Math.abs(seen.y) / tall) + seen.z);
    }
    far = 1.08 * far + 0.06 * extent;
    this.camera.position.copy(middle).addScaledVector(eye, far);
    this.camera.near = 0.02 * extent;
    this.camera.far = 40 * extent;
    this.camera.updateProjectionMatrix();
    this.controls.minDistance = 0.1 * extent;
    this.controls.maxDistance = 12 * extent;
    this.touched = view !== "free";
    this.controls.update();
    this.soon();
  }

  /** Turn about the vertical and up or down [steps], or come nearer. */
  nudge(around: number, up: number, nearer: number): void {
    this.touched = true;
    const way = this.camera.position.clone().sub(this.controls.target);
    const radius = way.length();
    const level = Math.hypot(way.x, way.y);
    const angle = Math.atan2(way.y, way.x) + TURN * around;
    const raised = Math.min(Math.max(Math.atan2(way.z, level) + TURN * up, -1.5), 1.5);
    way.set(Math.cos(raised) * Math.cos(angle), Math.cos(raised) * Math.sin(angle), Math.sin(raised));
    this.camera.position.copy(this.controls.target).addScaledVector(way, radius * NEARER ** nearer);
    this.controls.update();
    this.soon();
  }

  resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.touched) this.fit();
    this.soon();
  }

  dispose(): void {
    cancelAnimationFrame(this.waiting);
    this.clear();
    this.controls.dispose();
    this.grid.geometry.dispose();
    this.scale.forEach((mesh) => mesh.geometry.dispose());
    for (const material of [...Object.values(this.materials), this.grid.material]) material.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }

  private clear(): void {
    this.group.clear();
    this.bodies.forEach((body) => body.dispose?.());
    this.bodies = [];
    this.wires.forEach((material) => material.dispose());
    this.wires.clear();
  }

  private build(data: SceneData): void {
    this.clear();
    this.touched = false;
    for (const shape of data.shapes) {
      let material = this.materials[MADE[shape.kind]];
      if (shape.port !== undefined) {
        material = new MeshLambertMaterial();
        this.wires.set(shape.port, material);
      }
      const body = bodyOf(shape, material, shape.kind === "rotor" ? this.materials.rotor : this.materials.joint);
      this.bodies.push(body);
      this.group.add(body.object);
    }
  }

  /** The grid below everything, and the scale on it. */
  private ground(data: SceneData): void {
    const extent = this.motion?.extent ?? 1;
    this.step = round(0.2 * extent);
    const floor = data.low[2] - SCALE_AT[2] * extent;
    const middle = (k: 0 | 1): number => this.step * Math.round((0.5 * (data.low[k] + data.high[k])) / this.step);
    this.grid.position.set(middle(0), middle(1), floor);
    this.grid.scale.setScalar(this.step / 2);
    const [x, y] = [middle(0), data.low[1] - SCALE_AT[1] * extent];
    const ends = [new Vector3(x, y, floor), new Vector3(x + this.step, y, floor)];
    const thick = 0.003 * extent;
    const [bar, first, last] = this.scale as [Mesh, Mesh, Mesh];
    bar.position.copy(ends[0] as Vector3).lerp(ends[1] as Vector3, 0.5);
    bar.rotation.set(0, 0, Math.PI / 2);
    bar.scale.set(thick, this.step, thick);
    [first, last].forEach((mesh, k) => {
      mesh.position.copy(ends[k] as Vector3);
      mesh.scale.setScalar(2 * thick);
    });
    this.spots.splice(0, 2, ...ends);
    this.label.textContent = `${Number((1000 * this.step).toPrecision(3))} mm`;
  }

  private soon(): void {
    this.waiting ||= requestAnimationFrame(() => {
      this.waiting = 0;
      this.renderer.render(this.world, this.camera);
      this.name();
      this.rendered += 1;
      Object.assign(this.host.dataset, { rendered: this.rendered, time: this.time, held: this.renderer.info.memory.geometries });
    });
  }

  /** Write the length of the scale beside it. */
  private name(): void {
    const [first, last] = this.spots;
    if (!first || !last) return;
    const spot = first.clone().lerp(last, 0.5).project(this.camera);
    const { clientWidth: width, clientHeight: height } = this.host;
    const [x, y] = [(0.5 + 0.5 * spot.x) * width, (0.5 - 0.5 * spot.y) * height + 10];
    const inside = spot.z < 1 && x > 20 && x < width - 20 && y > 0 && y < height - 14;
    this.label.style.visibility = inside ? "visible" : "hidden";
    this.label.style.transform = `translate(${x.toFixed(0)}px, ${y.toFixed(0)}px) translateX(-50%)`;
  }
}

const MADE: Record<Kind, "ground" | "link" | "joint" | "spring" | "weight" | "rotor" | "tether"> = {
  ground: "ground", link: "link", joint: "joint", wire: "tether", spring: "spring", tether: "tether", weight: "weight",
  pulley: "ground", plate: "link", rotor: "ground", object: "joint",
};

/** A square grid of two units to a square, in the plane z = 0. */
function squares(): LineSegments<BufferGeometry, LineBasicMaterial> {
  const points: number[] = [];
  for (let k = -CELLS; k <= CELLS; k += 2) points.push(-CELLS, k, 0, CELLS, k, 0, k, -CELLS, 0, k, CELLS, 0);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  return new LineSegments(geometry, new LineBasicMaterial({ transparent: true, opacity: 0.8 }));
}
