// Mouse, finger and keys on a chart: a click picks, a drag zooms, a wheel with Ctrl or two fingers magnify, a drag of
// the time line (or of a finger over a chart of time) moves the cursor, a double click shows all.

import { signal } from "@preact/signals";
import { cursor } from "../state/run.ts";
import type { ChartProps } from "./chart.tsx";
import { lookAt, type Found } from "./hover.ts";
import { between, magnify, share, valueAt, type Scale } from "./scale.ts";
import type { Picture } from "./picture.ts";

/** How near to the time line a drag takes it, and how far a drag goes before it is one [px]. */
const NEAR = 7;
const LEAST = 5;
/** How fast the wheel magnifies, per unit of its delta. */
const SPEED = 0.004;

/** Whether the time cursor goes where the mouse points, as in a report. */
export const pointed = signal(false);

/** A chart, as pointers find it. */
export interface Pointed {
  over: HTMLElement;
  select: HTMLElement;
  props: () => ChartProps;
  /** What is drawn, zoomed as it is; and with all of it. */
  shown: () => Picture;
  whole: () => { x: Scale; y: Scale };
  zoom: (part: { x: Scale; y: Scale } | null) => void;
  look: (found: Found | null) => void;
}

interface Place {
  x: number;
  y: number;
}

export function pointing({ over, select, props, shown, whole, zoom, look }: Pointed): () => void {
  let begun: (Place & { scrub: boolean }) | null = null;
  let pinch: { apart: number; x: Scale; y: Scale } | null = null;
  const fingers = new Map<number, Place>();

  const place = (event: MouseEvent): Place => {
    const box = over.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const size = (): { width: number; height: number } => ({ width: over.clientWidth || 1, height: over.clientHeight || 1 });
  const shares = ({ x, y }: Place): [number, number] => [Math.max(0, Math.min(1, x / size().width)), 1 - y / size().height];
  const near = (x: number): boolean => !!props().timed && Math.abs(share(shown().x, cursor.peek()) * size().width - x) <= NEAR;
  const pick = (at: Place): void => {
    const [x, y] = shares(at);
    props().onPick?.(valueAt(shown().x, x), valueAt(shown().y, y), lookAt(shown(), size(), at.x, at.y));
  };
  const mark = (left: number, top: number, width: number, height: number): void => {
    select.hidden = width === 0;
    Object.assign(select.style, { left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${height}px` });
  };
  const magnified = (at: Place, factor: number, from: { x: Scale; y: Scale } = shown()): void => {
    const [x, y] = shares(at);
    const all = whole();
    const across = magnify(all.x, from.x, x, factor);
    const up = shown().along ? all.y : magnify(all.y, from.y, y, factor);
    zoom(across || (up && !shown().along) ? { x: across ?? all.x, y: up ?? all.y } : null);
  };
  const spread = (): { middle: Place; apart: number } => {
    const [a, b] = [...fingers.values()] as [Place, Place];
    return { middle: { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 }, apart: Math.max(Math.hypot(a.x - b.x, a.y - b.y), 1) };
  };

  const down = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    const at = place(event);
    over.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, at);
    if (fingers.size === 2) {
      begun = null;
      mark(0, 0, 0, 0);
      pinch = { apart: spread().apart, x: shown().x, y: shown().y };
    } else begun = { ...at, scrub: near(at.x) || (event.pointerType === "touch" && !!props().timed) };
  };
  const move = (event: PointerEvent): void => {
    const at = place(event);
    if (fingers.has(event.pointerId)) fingers.set(event.pointerId, at);
    if (pinch && fingers.size === 2) return magnified(spread().middle, pinch.apart / spread().apart, pinch);
    if (!begun) {
      over.style.cursor = near(at.x) ? "ew-resize" : "";
      if (pointed.peek() && event.pointerType !== "touch" && props().timed) return pick(at);
      return look(lookAt(shown(), size(), at.x, at.y));
    }
    look(null);
    if (begun.scrub) return pick(at);
    const full = shown().along;
    mark(Math.min(begun.x, at.x), full ? 0 : Math.min(begun.y, at.y), Math.abs(at.x - begun.x), full ? size().height : Math.abs(at.y - begun.y));
  };
  const lost = (event: PointerEvent): void => {
    fingers.delete(event.pointerId);
    if (fingers.size < 2) pinch = null;
    begun = null;
    mark(0, 0, 0, 0);
  };
  const up = (event: PointerEvent): void => {
    const [from, at] = [begun, place(event)];
    lost(event);
    if (!from) return;
    if (from.scrub || Math.abs(at.x - from.x) < LEAST) return pick(at);
    const [[x0, y0], [x1, y1]] = [shares(from), shares(at)];
    const part = { x: between(shown().x, x0, x1), y: shown().along ? shown().y : between(shown().y, y0, y1) };
    if (props().onSelect) props().onSelect?.(part.x.low, part.x.high);
    else if (part.y.high > part.y.low) zoom(part);
  };
  const wheel = (event: WheelEvent): void => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    magnified(place(event), Math.exp(event.deltaY * SPEED));
  };
  const heard: [string, (event: never) => void][] = [
    ["pointerdown", down], ["pointermove", move], ["pointerup", up], ["pointercancel", lost],
    ["pointerleave", () => look(null)], ["dblclick", () => zoom(null)], ["wheel", wheel],
  ];
  for (const [name, listener] of heard) over.addEventListener(name, listener as EventListener, { passive: name !== "wheel" });
  return () => heard.forEach(([name, listener]) => over.removeEventListener(name, listener as EventListener));
}
