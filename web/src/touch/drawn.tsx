// The moving point of a diagram, drawn by hand while the model runs.

import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { hand, pullAt } from "./live.ts";

/** How near to the point it is taken [px]; a finger is wider. */
const NEAR = { mouse: 22, touch: 44 };

export function Drawn({ children }: { children: ComponentChildren }) {
  const own = useRef<Element | null>(null);
  const down = (event: PointerEvent): void => {
    if (!hand.value || event.button !== 0) return;
    const dot = (event.currentTarget as Element).querySelector(".dot");
    const box = dot?.getBoundingClientRect();
    if (!dot || !box) return;
    const away = Math.hypot(event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2);
    if (away > (event.pointerType === "touch" ? NEAR.touch : NEAR.mouse)) return;
    event.stopPropagation(); // the chart would zoom
    event.preventDefault();
    own.current = dot;
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    move(event);
  };
  const move = (event: PointerEvent): void => {
    if (own.current) pullAt({ dot: own.current, x: event.clientX, y: event.clientY });
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
