// The mechanism in space, by WebGL. Renders when something has changed and never otherwise.

import {
  AmbientLight, BufferAttribute, DirectionalLight, HemisphereLight, Matrix4, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene,
  Vector3, WebGLRenderer, type Group, type Object3D,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { SceneData, Shape } from "../lib/types.ts";
import { Arrows } from "./arrows.ts";
import { place, type Spot } from "./camera.ts";
import { Cast } from "./cast.ts";
import { findCuts, lengthOf, type Cut } from "./cuts.ts";
import { Ground } from "./ground.ts";
import { arrange, Labels, type Word, type Written } from "./labels.ts";
import { Materials, type Colours } from "./materials.ts";
import { round, type Motion } from "./motion.ts";
import { Picker, type Grabbing, type Hit } from "./pick.ts";
import type { Rgb } from "./tint.ts";

export type View = "free" | "front" | "side" | "top";

/** What is known of the mechanism at a time. */
export interface Reading {
  colour: (port: string) => Rgb;
  /** Of an element [N]. */
  force: (port: string) => number;
  /** Largest force of all elements in the run [N]. */
  most: number;
  /** Name, what it is, and what it reads now; a line each. */
  words: (shape: Shape, extent: number) => string[];
}

const EYES: Record<View, [number, number, number]> = {
  free: [0.3, -1, 0.28], front: [0, -1, 0], side: [1, 0, 0], top: [0, -0.001, 1],
};
const CORNER: [number, number, number] = [0.62, -1, 0.42];
const FIELD = 22;
const TURN = 0.12;
const NEARER = 0.88;
/** Share of half a frame that is filled: names need some room. */
const ROOM: [number, number] = [0.93, 0.88];
/** Pictures of a run that the camera is fitted to. */
const FITTED = 9;
/** Rest after which a picture is drawn again with smooth edges, where that costs much [ms]. */
const REST = 130;
/** So many elements have their values beside their names. */
const FEW = 4;
/** Kinds that are named, the first ones first. */
const NAMED = ["wire", "weight", "phalanx", "fingertip", "palm", "plate", "pulley", "motor", "rotor", "beam", "cylinder", "slider", "spring", "object", "link"];

/** Asked of WebGL. Where a processor has to draw, edges are not smoothed while anything moves, which costs it most. */
const ASKED = { alpha: true, antialias: true, powerPreference: "low-power" } as const;

export class Stage {
  /** Pictures that were rendered. */
  rendered = 0;
  /** Length of a square of the grid [m]. */
  step = 0;
  /** Names of everything, and forces as arrows. */
  named = false;
  forces = false;
  grabbing: Grabbing | null = null;

  private readonly renderer: WebGLRenderer;
  private readonly quick: boolean;
  private readonly world = new Scene();
  private readonly camera = new PerspectiveCamera(FIELD, 1, 0.01, 10);
  private readonly controls: OrbitControls;
  private readonly materials: Materials;
  private readonly faint = new MeshLambertMaterial({
    transparent: true, opacity: 0.28, depthWrite: false,
    // what is where it was is not tinted
    polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8,
  });
  private readonly ground = new Ground();
  private readonly labels: Labels;
  private readonly picker: Picker;
  private readonly arrows: Arrows;
  private cast: Cast | null = null;
  private ghost: Cast | null = null;
  private cuts: Cut[] = [];
  private spots: Spot[] = [];
  private fitted = "";
  private touched = false;
  private waiting = 0;
  private resting = 0;
  private time = 0;
  private reading: Reading | null = null;
  private hover: Hit | null = null;
  private held: Hit | null = null;

  /** `smooth`: pixels of the picture for one of the page, where it is not drawn by itself but when asked to. */
  constructor(
    private readonly host: HTMLElement,
    private readonly smooth = 0,
  ) {
    const canvas = document.createElement("canvas");
    const context = canvas.getContext("webgl2", { ...ASKED, failIfMajorPerformanceCaveat: true });
    this.quick = context !== null;
    this.renderer = new WebGLRenderer(context ? { canvas, context } : { ...ASKED, canvas, antialias: false });
    this.renderer.setPixelRatio(smooth || (this.quick ? Math.min(devicePixelRatio, 2) : 1));
    this.renderer.autoClear = true;
    canvas.setAttribute("aria-hidden", "true");
    host.prepend(canvas);
    this.materials = new Materials(this.quick);
    this.labels = new Labels(host);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.soon());
    this.controls.addEventListener("start", () => (this.touched = true));
    this.picker = new Picker(this.camera, canvas);
    this.arrows = new Arrows(this.materials.made.force);
    this.light();
    this.world.add(this.camera, ...this.ground.parts, this.arrows.group);
    this.listen(canvas);
    this.resize();
  }

  get motion(): Motion | null {
    return this.cast?.motion ?? null;
  }

  /** Show a run, and a pinned one as its ghost; long straight parts are drawn broken unless `whole`. */
  show(data: SceneData, pinned: SceneData | null = null, whole = false): void {
    const same = pinned && pinned.shapes.map((s) => s.kind).join() === data.shapes.map((s) => s.kind).join() ? pinned : null;
    this.cuts = whole ? [] : findCuts(same ? [data, same] : [data]);
    this.cast = this.followed(this.cast, data, null);
    this.ghost = this.followed(this.ghost, same, this.faint);
    const { low, high, extent } = this.cast.motion;
    const where = [...this.cast.targets.map(({ name }) => name), whole, this.cuts.length, this.ghost !== null, ...[...low, ...high].map((x) => (x / extent).toFixed(1)), extent.toPrecision(2)].join();
    const names = (key: string): string => key.split(",").slice(0, data.shapes.length).join();
    if (where !== this.fitted || !this.spots.length) {
      this.measure([this.cast, ...(this.ghost ? [this.ghost] : [])]);
      if (!this.touched || names(where) !== names(this.fitted)) this.fit();
    }
    this.fitted = where;
  }

  /** Put everything to where it is at a time [s]. */
  put(time: number, reading: Reading): void {
    this.time = time;
    this.reading = reading;
    this.cast?.put(time, reading.colour);
    this.ghost?.put(time);
    this.soon();
  }

  /** Draw again with other things switched on. */
  look(what: { named?: boolean; forces?: boolean }): void {
    Object.assign(this, what);
    this.soon();
  }

  paint(colours: Colours): void {
    const dark = this.materials.paint(colours);
    this.ground.paint(colours.line, dark);
    this.faint.color.set(colours.accent);
    this.soon();
  }

  /** Look at the whole motion. */
  fit(view: View = "free"): void {
    const extent = this.motion?.extent;
    if (!extent || !this.spots.length) return;
    const { low, high } = this.motion as Motion;
    // what is as deep as it is wide is seen from its corner
    const deep = high[1] - low[1] > 0.3 * (high[0] - low[0]);
    const eye = view === "free" && deep ? CORNER : EYES[view];
    const target = place(this.camera, this.spots, new Vector3(...eye).normalize(), ROOM, extent);
    this.controls.target.copy(target);
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
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.touched) this.fit();
    this.soon();
  }

  /** The mechanism as it stands, for those who take it away. */
  get model(): { group: Group; motion: Motion; put: (time: number) => void } | null {
    const { cast } = this;
    return cast && { group: cast.group, motion: cast.motion, put: (time) => cast.put(time, this.reading?.colour) };
  }

  /** Name of the shape that an object is of. */
  nameOf(object: Object3D): string {
    return this.cast?.targets.find((target) => target.object === object)?.name ?? "";
  }

  /** The picture now, and its words: what it is drawn on is the canvas until the next one. */
  render(): { canvas: HTMLCanvasElement; words: Written[] } {
    const shown = this.forces ? this.arrows.point(this.cast, this.reading) : this.arrows.hide();
    const ghost = this.ghost?.group;
    if (ghost) ghost.visible = false;
    this.arrows.group.visible = false;
    this.ground.cast(this.renderer, this.world);
    if (ghost) ghost.visible = true;
    this.arrows.group.visible = true;
    this.renderer.render(this.world, this.camera);
    const { clientWidth: width, clientHeight: height } = this.host;
    return { canvas: this.renderer.domElement, words: arrange([...this.words(), ...shown], this.camera, width, height) };
  }

  /** See the mechanism as another stage does. */
  follow(other: Stage): void {
    this.camera.position.copy(other.camera.position);
    this.camera.quaternion.copy(other.camera.quaternion);
    this.camera.near = other.camera.near;
    this.camera.far = other.camera.far;
    this.camera.updateProjectionMatrix();
    Object.assign(this, { named: other.named, forces: other.forces, touched: true });
  }

  dispose(): void {
    cancelAnimationFrame(this.waiting);
    clearTimeout(this.resting);
    this.cast?.dispose();
    this.ghost?.dispose();
    this.controls.dispose();
    this.ground.dispose();
    this.materials.dispose();
    this.faint.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }

  private followed<T extends SceneData | null>(old: Cast | null, data: T, ghost: MeshLambertMaterial | null): T extends null ? null : Cast {
    type Found = T extends null ? null : Cast;
    if (old && data && old.follow(data, this.cuts)) return old as Found;
    old?.dispose();
    if (!data) return null as Found;
    const made = new Cast(data, this.cuts, this.materials, ghost);
    this.world.add(made.group);
    return made as Found;
  }

  private light(): void {
    const [lamp, rim] = [new DirectionalLight(0xffffff, 1.9), new DirectionalLight(0xffffff, 0.8)];
    this.camera.add(lamp, lamp.target, rim, rim.target);
    lamp.position.set(-0.7, 1, 0.6);
    rim.position.set(1, 0.4, -0.6);
    for (const one of [lamp, rim]) one.target.position.set(0, 0, -1);
    const sky = new HemisphereLight(0xffffff, 0x8a8a90, 1.5);
    sky.position.set(0, 0, 1);
    this.world.add(sky, new AmbientLight(0xffffff, 0.35));
  }

  /** What the camera must see: corners of everything over the run, and the floor below it. */
  private measure(casts: Cast[]): void {
    this.spots = [];
    for (const cast of casts) {
      const { times } = cast.motion.data;
      for (let k = 0; k < FITTED; k++) {
        cast.put(times[Math.round((k * (times.length - 1)) / (FITTED - 1))] ?? 0);
        cast.group.updateMatrixWorld(true);
        cast.group.traverseVisible((one) => one instanceof Mesh && this.spots.push(...cornersOf(one)));
      }
    }
    const [low, high] = [[0, 1, 2], [0, 1, 2]].map((axes, side) =>
      axes.map((axis) => this.spots.reduce((found, [at]) => Math[side ? "max" : "min"](found, at.getComponent(axis)), side ? -Infinity : Infinity)),
    ) as [number[], number[]];
    const extent = Math.hypot(...high.map((x, k) => x - (low[k] ?? 0)));
    this.step = round(0.14 * extent);
    this.ground.put(low, high, (low[2] ?? 0) - 0.03 * extent, this.step);
    this.host.dataset.grid = `${Number((1000 * this.step).toPrecision(3))} mm`;
  }

  private listen(canvas: HTMLCanvasElement): void {
    const targets = (): Cast["targets"] => this.cast?.targets ?? [];
    canvas.addEventListener("pointermove", (event) => {
      if (this.held) {
        const point = this.picker.within(event, this.held.point);
        if (point) this.grabbing?.onDrag(this.held.target.name, point.toArray());
        return;
      }
      if (event.buttons) return;
      const found = this.picker.pick(event, targets());
      if (found?.target !== this.hover?.target) this.soon();
      this.hover = found;
      canvas.style.cursor = found && this.grabbing?.may(found.target.name) ? "grab" : "";
    });
    canvas.addEventListener("pointerleave", () => {
      this.hover = null;
      this.soon();
    });
    // before the controls of the camera, which would turn it
    this.host.addEventListener(
      "pointerdown",
      (event) => {
        const found = this.grabbing && event.button === 0 ? this.picker.pick(event, targets()) : null;
        if (!found || !this.grabbing?.may(found.target.name)) return;
        event.stopPropagation();
        this.held = found;
        canvas.setPointerCapture(event.pointerId);
        this.grabbing.onGrab(found.target.name, found.point.toArray());
      },
      { capture: true },
    );
    for (const kind of ["pointerup", "pointercancel"] as const) {
      canvas.addEventListener(kind, () => {
        if (this.held) this.grabbing?.onRelease(this.held.target.name);
        this.held = null;
      });
    }
  }

  /** What is written over the picture. */
  private words(): Word[] {
    const { cast, reading, hover } = this;
    if (!cast || !reading) return [];
    const { shapes } = cast.motion.data;
    const middle = (k: number): Vector3 => midst(cast.targets[k]?.points ?? []);
    const found: Word[] = [];
    const over = hover ? cast.targets.indexOf(hover.target) : -1;
    const under = shapes[over];
    if (hover && under) found.push({ text: reading.words(under, cast.motion.extent).join("\n"), at: hover.point, kind: "hover" });
    for (const axis of new Set(this.cuts.map((cut) => cut.axis))) {
      const along = this.cuts.filter((cut) => cut.axis === axis).sort((a, b) => lengthOf(b) - lengthOf(a));
      const mark = cast.breaks.find((one) => one.mark.object.visible && one.mark.cut === along[0])?.mark;
      const lost = along.reduce((sum, cut) => sum + lengthOf(cut), 0);
      if (mark) found.push({ text: `${Number((1000 * lost).toPrecision(3))} mm not drawn`, at: mark.at, kind: "cut" });
    }
    shapes.forEach((shape, k) => {
      if (shape.mass && k !== over) {
        found.push({ text: mass(shape.mass), at: middle(k).add(new Vector3(0, 0, -1.45 * shape.size)), kind: "mass" });
      }
    });
    if (this.named) {
      const order = shapes.map((_, k) => k).filter((k) => NAMED.includes(shapes[k]?.kind ?? "") && k !== over);
      // of many elements the values would hide the mechanism
      const few = cast.wires <= FEW;
      const rank = (k: number): number => (shapes[k]?.port !== undefined && !few ? NAMED.length : NAMED.indexOf(shapes[k]?.kind ?? ""));
      order.sort((a, b) => rank(a) - rank(b));
      for (const k of order) {
        const [name = "", , value] = reading.words(shapes[k] as Shape, cast.motion.extent);
        found.push({ text: value && few && shapes[k]?.port ? `${name}: ${value}` : name, at: middle(k), kind: "name" });
      }
    }
    return found;
  }

  private soon(): void {
    if (this.smooth) return;
    this.waiting ||= requestAnimationFrame(() => {
      this.waiting = 0;
      if (!this.quick && this.renderer.getPixelRatio() !== 1) this.renderer.setPixelRatio(1);
      this.draw();
      if (this.quick) return;
      clearTimeout(this.resting);
      this.resting = window.setTimeout(() => {
        this.renderer.setPixelRatio(2);
        this.draw();
      }, REST);
    });
  }

  private draw(): void {
    this.labels.write(this.render().words);
    this.rendered += 1;
    Object.assign(this.host.dataset, { rendered: this.rendered, time: this.time, held: this.renderer.info.memory.geometries });
  }
}

/** A mass in words. */
const mass = (kilograms: number): string =>
  kilograms < 1 ? `${Number((1000 * kilograms).toPrecision(3))} g` : `${Number(kilograms.toPrecision(3))} kg`;

/** The middle of a line; of other points, their mean. */
function midst(points: Vector3[]): Vector3 {
  const k = Math.max(1, Math.floor(points.length / 2));
  const [a = new Vector3(), b = a] = points.length === 2 ? points : [points[k - 1], points[k]];
  return a.clone().lerp(b, 0.5);
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
