// The moving point of a diagram, drawn by hand while the model runs.

import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { portsOf } from "../plots/drawn.ts";
import { run } from "../state/run.ts";
import { hand, pullAt } from "./live.ts";

/** How near to the point it is taken [px]; a finger is wider. */
const NEAR = { mouse: 22, touch: 44 };

/** A point of the diagram and the drive that heats its element. */
interface Taken {
  dot: Element;
  drive: number;
}

/** The point nearest to the pointer, if it is near enough. */
function take(home: Element, event: PointerEvent): Taken | null {
  const reach = event.pointerType === "touch" ? NEAR.touch : NEAR.mouse;
  const away = (dot: Element): number => {
    const box = dot.getBoundingClientRect();
    return Math.hypot(event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2);
  };
  const dots = [...home.querySelectorAll(".dot")];
  const k = dots.reduce((best, dot, own) => (best < 0 || away(dot) < away(dots[best]!) ? own : best), -1);
  if (k < 0 || away(dots[k]!) > reach) return null;
  const port = run.value ? portsOf(run.value)[k] : "";
  return { dot: dots[k]!, drive: hand.value!.drives.findIndex((one) => one.drive.port === port) };
}

export function Drawn({ children }: { children: ComponentChildren }) {
  const own = useRef<Taken | null>(null);
  const down = (event: PointerEvent): void => {
    if (!hand.value || event.button !== 0) return;
    const home = event.currentTarget as Element;
    own.current = take(home, event);
    if (!own.current) return;
    event.stopPropagation(); // the chart would zoom
    event.preventDefault();
    home.setPointerCapture(event.pointerId);
    move(event);
  };
  const move = (event: PointerEvent): void => {
    if (own.current) pullAt({ ...own.current, x: event.clientX, y: event.clientY });
  };
  const up = (): void => {
    if (own.current) pullAt(null);
    own.current = null;
  };
  return (
    <div class={hand.value ? "drawn" : ""} onPointerDownCapture={down} onPointerMove={move} onPointerUp={up} onPointerCancel={up}>
      {children}
    </div>
  );
}
