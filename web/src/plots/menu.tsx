// A button that opens a small panel below it; Escape or a press elsewhere closes it.

import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";

export function Menu({ name, about, children }: { name: string; about?: string; children: ComponentChildren }) {
  const home = useRef<HTMLDetailsElement>(null);
  useEffect(() => {
    const close = (): void => void (home.current && (home.current.open = false));
    const pressed = (event: PointerEvent): void => {
      if (!home.current?.contains(event.target as Node)) close();
    };
    const keyed = (event: KeyboardEvent): void => {
      if (event.key !== "Escape" || !home.current?.open) return;
      close();
      home.current.querySelector("summary")?.focus();
    };
    addEventListener("pointerdown", pressed);
    addEventListener("keydown", keyed);
    return () => {
      removeEventListener("pointerdown", pressed);
      removeEventListener("keydown", keyed);
    };
  }, []);
  /** At once, not when the browser comes to it: nothing moves below a pointer that is under way. */
  const flip = (event: Event): void => {
    event.preventDefault();
    if (!home.current) return;
    home.current.open = !home.current.open;
    if (home.current.open) home.current.querySelector(".menu-body")?.scrollIntoView({ block: "nearest" });
  };
  return (
    <details class="menu" ref={home}>
      <summary aria-label={about} title={about} onClick={flip}>{name}</summary>
      <div class="menu-body">{children}</div>
    </details>
  );
}
