// What is under the pointer, and taking hold of it.

import { Plane, Raycaster, Vector2, Vector3, type Camera, type Object3D } from "three";

/** Told while something is held; points [m], as drawn, lie in the plane through it that faces the camera. */
export interface Grabbing {
  /** Whether a shape of this name can be held. */
  may: (name: string) => boolean;
  onGrab: (name: string, point: [number, number, number]) => void;
  onDrag: (name: string, point: [number, number, number]) => void;
  onRelease: (name: string) => void;
}

/** Something that can be picked: an object, and the line through its points. */
export interface Target {
  name: string;
  object: Object3D;
  points: Vector3[];
}

/** How near to a line the pointer must be [px]. */
const NEAR = 9;

export interface Hit {
  target: Target;
  point: Vector3;
}

export class Picker {
  private readonly ray = new Raycaster();
  private readonly place = new Vector2();

  constructor(
    private readonly camera: Camera,
    private readonly canvas: HTMLElement,
  ) {}

  /** The first thing under the pointer, or else the nearest line. */
  pick(event: { clientX: number; clientY: number }, targets: Target[]): Hit | null {
    this.aim(event);
    const found = targets
      .flatMap((target) => this.ray.intersectObject(target.object, true).map(({ distance, point }) => ({ target, point, distance })))
      .sort((a, b) => a.distance - b.distance)[0];
    return found ?? this.nearest(event, targets);
  }

  /** Where the pointer is in the plane through a point that faces the camera. */
  within(event: { clientX: number; clientY: number }, point: Vector3): Vector3 | null {
    this.aim(event);
    const plane = new Plane().setFromNormalAndCoplanarPoint(this.camera.getWorldDirection(new Vector3()), point);
    return this.ray.ray.intersectPlane(plane, new Vector3());
  }

  private aim(event: { clientX: number; clientY: number }): void {
    const box = this.canvas.getBoundingClientRect();
    this.place.set((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    this.ray.setFromCamera(this.place, this.camera);
  }

  private nearest(event: { clientX: number; clientY: number }, targets: Target[]): Hit | null {
    const box = this.canvas.getBoundingClientRect();
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    let best = NEAR;
    let found: Hit | null = null;
    for (const target of targets) {
      const seen = target.points.map((point) => {
        const spot = point.clone().project(this.camera);
        return [(0.5 + 0.5 * spot.x) * box.width, (0.5 - 0.5 * spot.y) * box.height] as const;
      });
      for (let k = 1; k < seen.length; k++) {
        const [[ax, ay], [bx, by]] = [seen[k - 1] as [number, number], seen[k] as [number, number]];
        const square = (bx - ax) ** 2 + (by - ay) ** 2 || 1;
        const share = Math.min(Math.max(((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / square, 0), 1);
        const away = Math.hypot(ax + share * (bx - ax) - px, ay + share * (by - ay) - py);
        if (away >= best) continue;
        best = away;
        found = { target, point: (target.points[k - 1] as Vector3).clone().lerp(target.points[k] as Vector3, share) };
      }
    }
    return found;
  }
}

/** The pointer over a canvas: what it is over, and what it holds. */
export class Pointer {
  hover: Hit | null = null;
  grabbing: Grabbing | null = null;
  private held: Hit | null = null;

  constructor(
    host: HTMLElement,
    private readonly canvas: HTMLCanvasElement,
    private readonly picker: Picker,
    private readonly targets: () => Target[],
    private readonly changed: () => void,
  ) {
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerleave", () => this.over(null));
    // before the controls of the camera, which would turn it
    host.addEventListener("pointerdown", (event) => this.press(event), { capture: true });
    for (const kind of ["pointerup", "pointercancel"] as const) canvas.addEventListener(kind, () => this.release());
  }

  private over(found: Hit | null): void {
    if (found?.target !== this.hover?.target) this.changed();
    this.hover = found;
  }

  private move(event: PointerEvent): void {
    if (this.held) {
      const point = this.picker.within(event, this.held.point);
      if (point) this.grabbing?.onDrag(this.held.target.name, point.toArray());
    } else if (!event.buttons) {
      this.over(this.picker.pick(event, this.targets()));
      this.canvas.style.cursor = this.hover && this.grabbing?.may(this.hover.target.name) ? "grab" : "";
    }
  }

  private press(event: PointerEvent): void {
    const found = this.grabbing && event.button === 0 ? this.picker.pick(event, this.targets()) : null;
    if (!found || !this.grabbing?.may(found.target.name)) return;
    event.stopPropagation();
    this.held = found;
    this.canvas.setPointerCapture(event.pointerId);
    this.grabbing.onGrab(found.target.name, found.point.toArray());
  }

  private release(): void {
    if (this.held) this.grabbing?.onRelease(this.held.target.name);
    this.held = null;
  }
}
