// The mechanism in space, by WebGL. Renders when something has changed and never otherwise.

import {
  AmbientLight, DirectionalLight, HemisphereLight, MeshLambertMaterial, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
  type Group, type Object3D,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { SceneData, Shape } from "../lib/types.ts";
import { Arrows } from "./arrows.ts";
import { chooseBar, placeCamera, type Spot } from "./camera.ts";
import { Cast } from "./cast.ts";
import { findCuts, type Cut } from "./cuts.ts";
import { Ground } from "./ground.ts";
import { arrangeLabels, Labels, type Written } from "./labels.ts";
import { Materials, type Colours } from "./materials.ts";
import { round, type Motion } from "./motion.ts";
import { Pace, SELDOM } from "./pace.ts";
import { Picker, Pointer, type Grabbing } from "./pick.ts";
import { boundsOf, spotsOf } from "./spots.ts";
import type { Rgb } from "./tint.ts";
import { wordsOf } from "./words.ts";

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
/** So soon after a run another one is taken to follow it [ms]. */
const FOLLOWING = 300;
const PRESSES = ["pointerdown", "pointerup", "pointercancel"] as const;
/** Between two looks at whether a picture is drawn [ms]. */
const POLL = 8;
/** Share of the whole motion, and angle [rad], below which nothing is seen of a change. */
const UNSEEN = 2e-4;

/** Asked of WebGL. Where a processor has to draw, edges are not smoothed while anything moves, which costs it most. */
const ASKED = { alpha: true, antialias: true, powerPreference: "low-power" } as const;

/** Names of what draws by the processor, where a browser does not say so otherwise. */
const PROCESSOR = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** A canvas, what draws on it, and whether that is not the processor. Throws where there is no WebGL. */
function openCanvas(): [HTMLCanvasElement, WebGL2RenderingContext, boolean] {
  const canvas = document.createElement("canvas");
  const quick = canvas.getContext("webgl2", { ...ASKED, failIfMajorPerformanceCaveat: true });
  const named = quick?.getExtension("WEBGL_debug_renderer_info");
  if (quick && !(named && PROCESSOR.test(String(quick.getParameter(named.UNMASKED_RENDERER_WEBGL))))) return [canvas, quick, true];
  quick?.getExtension("WEBGL_lose_context")?.loseContext();
  const other = document.createElement("canvas");
  const context = other.getContext("webgl2", { ...ASKED, antialias: false });
  if (!context) throw new Error("There is no WebGL.");
  return [other, context, false];
}

export class Stage {
  /** Pictures that were rendered. */
  rendered = 0;
  /** Names of everything, and forces as arrows. */
  named = false;
  forces = false;

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
  private readonly pointer: Pointer;
  private readonly arrows: Arrows;
  private cast: Cast | null = null;
  private ghost: Cast | null = null;
  private cuts: Cut[] = [];
  private spots: Spot[] = [];
  private fitted = "";
  private touched = false;
  private waiting = 0;
  private resting = 0;
  private drawn = 0;
  private readonly pace = new Pace();
  /** Ends when the processor has drawn the last picture. */
  private fence: WebGLSync | null = null;
  private pressed = false;
  private grabbed = false;
  private shown = 0;
  /** What was put on the stage last, as far as it is seen. */
  private seen = "";
  private time = 0;
  private reading: Reading | null = null;

  /** `smooth`: pixels of the picture for one of the page, where it is not drawn by itself but when asked to. */
  constructor(
    private readonly host: HTMLElement,
    private readonly smooth = 0,
  ) {
    const [canvas, context, quick] = openCanvas();
    this.quick = quick;
    this.renderer = new WebGLRenderer({ canvas, context });
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
    this.arrows = new Arrows(this.materials.made.force);
    this.light();
    this.world.add(this.camera, ...this.ground.parts, this.arrows.group);
    this.pointer = new Pointer(host, canvas, new Picker(this.camera, canvas), () => this.cast?.targets ?? [], () => this.soon());
    if (!quick) for (const kind of PRESSES) addEventListener(kind, this.onPress, { capture: true });
    this.resize();
  }

  private readonly onPress = ({ type }: Event): void => void (this.pressed = type === "pointerdown");

  /** Who is told while something is held. */
  set grabbing(grabbing: Grabbing | null) {
    this.pointer.grabbing = grabbing;
    this.grabbed = grabbing !== null;
  }

  /** Shortest time between two pictures in motion [ms]. */
  get interval(): number {
    return this.quick ? 0 : SELDOM;
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
    this.shown = performance.now();
  }

  /** Put everything to where it is at a time [s]. */
  put(time: number, reading: Reading): void {
    this.time = time;
    this.reading = reading;
    this.cast?.put(time, reading.colour);
    this.ghost?.put(time);
    const seen = this.describe();
    if (seen && seen === this.seen) this.host.dataset.time = String(time);
    else this.soon();
    this.seen = seen;
  }

  /** All that is seen, in letters; empty where words stand beside it, which change with every number. */
  private describe(): string {
    if (this.named || this.forces || this.pointer.hover || !this.cast) return "";
    const casts = [this.cast, ...(this.ghost ? [this.ghost] : [])];
    const looks = casts.map(({ id, motion }) => {
      const { shapes, ports } = motion.data;
      const places = Array.from(motion.places, (x) => Math.round(x / (UNSEEN * motion.extent)));
      const slack = Object.keys(ports).map((port) => motion.slack(port, this.time));
      return [id, places, motion.turns.map((x) => Math.round(x / UNSEEN)), slack, shapes.map(({ mass, size, diameter, coils }) => [mass, size, diameter, coils])];
    });
    const colours = Object.keys(this.cast.motion.data.ports).map((port) => this.reading?.colour(port).map(Math.round));
    return JSON.stringify([this.fitted, looks, colours, this.cuts]);
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
    const target = placeCamera(this.camera, this.spots, new Vector3(...eye).normalize(), ROOM, extent);
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
  render(shadow = true): { canvas: HTMLCanvasElement; words: Written[] } {
    const shown = this.forces ? this.arrows.point(this.cast, this.reading) : this.arrows.hide();
    if (shadow) this.castShadow();
    this.renderer.render(this.world, this.camera);
    const { clientWidth: width, clientHeight: height } = this.host;
    return { canvas: this.renderer.domElement, words: arrangeLabels([...wordsOf(this.cast, this.reading, this.pointer.hover, this.named), ...shown], this.camera, width, height) };
  }

  private castShadow(): void {
    const ghost = this.ghost?.group;
    if (ghost) ghost.visible = false;
    this.arrows.group.visible = false;
    this.ground.cast(this.renderer, this.world);
    if (ghost) ghost.visible = true;
    this.arrows.group.visible = true;
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
    this.fence = null;
    for (const kind of PRESSES) removeEventListener(kind, this.onPress, { capture: true });
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

  private measure(casts: Cast[]): void {
    this.spots = casts.flatMap(spotsOf);
    const [low, high] = boundsOf(this.spots);
    const extent = Math.hypot(...high.map((x, k) => x - (low[k] ?? 0)));
    this.ground.put(low, high, (low[2] ?? 0) - 0.03 * extent, round(0.14 * extent));
  }

  /** A bar of a round length, as long as that length is in the middle of the picture. */
  private measureBar(): void {
    const away = this.camera.position.distanceTo(this.controls.target);
    const [length, pixels] = chooseBar(this.host.clientHeight / (2 * Math.tan((Math.PI / 360) * FIELD) * away));
    this.host.dataset.bar = `${Number((1000 * length).toPrecision(3))} mm`;
    this.host.style.setProperty("--bar", `${pixels.toFixed(1)}px`);
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

  private soon(): void {
    if (this.smooth) return;
    clearTimeout(this.resting);
    this.pace.change(performance.now());
    this.waiting ||= requestAnimationFrame(() => this.next());
  }

  /** Draw, unless a processor that draws has to leave the rest of the page its time. */
  private next(): void {
    const begun = performance.now();
    const isHurried = this.grabbed || begun - this.shown < FOLLOWING;
    const isEarly = this.fence !== null || (isHurried && begun - this.drawn < this.interval);
    if (!this.quick && isEarly) return void (this.waiting = requestAnimationFrame(() => this.next()));
    this.waiting = 0;
    this.drawn = begun;
    if (this.quick) this.draw();
    else this.drawPaced(true);
  }

  /** Draw by the processor, measure the cost, and draw what is missing after a rest. */
  private drawPaced(isMoving: boolean): void {
    const { pixels, shadow } = this.pace.begin(performance.now(), isMoving, this.host.clientHeight);
    if (this.renderer.getPixelRatio() !== pixels) this.renderer.setPixelRatio(pixels);
    const begun = performance.now();
    this.draw(shadow);
    const context = this.renderer.getContext() as WebGL2RenderingContext;
    this.fence = context.fenceSync(context.SYNC_GPU_COMMANDS_COMPLETE, 0);
    context.flush();
    const look = (): void => {
      if (!this.fence) return; // the stage is disposed
      if (context.getSyncParameter(this.fence, context.SYNC_STATUS) === context.UNSIGNALED) return void setTimeout(look, POLL);
      context.deleteSync(this.fence);
      this.fence = null;
      this.pace.end(performance.now() - begun, pixels);
      this.restThenDraw();
    };
    setTimeout(look, POLL);
  }

  private restThenDraw(): void {
    const { rest } = this.pace;
    clearTimeout(this.resting);
    if (rest === null || this.waiting) return;
    this.resting = window.setTimeout(() => (this.pressed ? this.restThenDraw() : this.drawPaced(false)), rest);
  }

  private draw(shadow = true): void {
    this.labels.write(this.render(shadow).words);
    this.measureBar();
    this.rendered += 1;
    Object.assign(this.host.dataset, { rendered: this.rendered, time: this.time, held: this.renderer.info.memory.geometries });
  }
}
