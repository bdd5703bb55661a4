// Mouse and finger on a chart: a click picks, a drag zooms, a drag of the time line (or of a finger
// over a chart of time) moves the cursor, a double click shows all.

import { signal } from "@preact/signals";
import type uPlot from "uplot";
import { cursor } from "../state/run.ts";
import type { ChartProps } from "./chart.tsx";

/** How near to the time line a drag takes it, and how far a drag goes before it is one [px]. */
const NEAR = 7;
const LEAST = 5;

/** Whether the time cursor goes where the mouse points, as in a report. */
export const pointed = signal(false);

export function pointing(u: uPlot, props: { current: ChartProps }): () => void {
  const { over } = u;
  let begun: { x: number; y: number; scrub: boolean } | null = null;

  const place = (event: PointerEvent | MouseEvent): { x: number; y: number } => {
    const box = over.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const near = (x: number): boolean => !!props.current.timed && Math.abs(u.valToPos(cursor.peek(), "x") - x) <= NEAR;
  const pick = (x: number, y: number): void => {
    const clamped = Math.max(0, Math.min(over.clientWidth, x));
    props.current.onPick(u.posToVal(clamped, "x"), u.posToVal(y, "y"));
  };

  const down = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    const { x, y } = place(event);
    begun = { x, y, scrub: near(x) || (event.pointerType === "touch" && !!props.current.timed) };
    over.setPointerCapture(event.pointerId);
  };
  const move = (event: PointerEvent): void => {
    const { x, y } = place(event);
    if (!begun) {
      over.style.cursor = near(x) ? "ew-resize" : "";
      if (pointed.peek() && event.pointerType !== "touch") pick(x, y);
      return;
    }
    if (begun.scrub) return pick(x, y);
    const timed = props.current.timed;
    const top = timed ? 0 : Math.min(begun.y, y);
    const height = timed ? over.clientHeight : Math.abs(y - begun.y);
    u.setSelect({ left: Math.min(begun.x, x), width: Math.abs(x - begun.x), top, height }, false);
  };
  const up = (event: PointerEvent): void => {
    if (!begun) return;
    const { x, y } = place(event);
    const { x: x0, y: y0, scrub } = begun;
    begun = null;
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    if (scrub || Math.abs(x - x0) < LEAST) return pick(x, y);
    const [a, b] = [u.posToVal(Math.min(x0, x), "x"), u.posToVal(Math.max(x0, x), "x")];
    props.current.onZoom([a, b], [u.posToVal(Math.max(y0, y), "y"), u.posToVal(Math.min(y0, y), "y")]);
  };
  const lost = (): void => {
    begun = null;
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  };
  const twice = (): void => props.current.onReset();

  over.addEventListener("pointerdown", down);
  over.addEventListener("pointermove", move);
  over.addEventListener("pointerup", up);
  over.addEventListener("pointercancel", lost);
  over.addEventListener("dblclick", twice);
  return () => {
    over.removeEventListener("pointerdown", down);
    over.removeEventListener("pointermove", move);
    over.removeEventListener("pointerup", up);
    over.removeEventListener("pointercancel", lost);
    over.removeEventListener("dblclick", twice);
  };
}
