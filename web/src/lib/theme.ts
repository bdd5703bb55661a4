// Colours as the page's style has them now, for canvases: light, dark, or switched.

import { signal } from "@preact/signals";

export interface Palette {
  /** Of the curves, by number. */
  curves: string[];
  ink: string;
  soft: string;
  line: string;
  panel: string;
  accent: string;
  bad: string;
}

export const CURVES = 6;

/** Custom properties with light-dark() are resolved only where they are used as a colour. */
function read(): Palette {
  const probe = document.createElement("span");
  probe.style.display = "none";
  document.body.append(probe);
  const colour = (name: string): string => {
    probe.style.color = `var(--${name})`;
    return getComputedStyle(probe).color;
  };
  const found: Palette = {
    curves: Array.from({ length: CURVES }, (_, k) => colour(`curve-${k}`)),
    ink: colour("ink"),
    soft: colour("soft"),
    line: colour("line"),
    panel: colour("panel"),
    accent: colour("accent"),
    bad: colour("bad"),
  };
  probe.remove();
  return found;
}

export const palette = signal<Palette>(read());

const renew = (): void => void (palette.value = read());
addEventListener("martensite-theme", renew);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", renew);
