// Colours of curves as the page's style has them now: light, dark, or switched.

import { signal } from "@preact/signals";

export interface Palette {
  curves: string[];
  ink: string;
  soft: string;
  line: string;
  panel: string;
  accent: string;
  bad: string;
}

const CURVES = 6;

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

/** The same colour, seen through. */
export function faint(colour: string, alpha: number): string {
  const [r = "0", g = "0", b = "0"] = colour.match(/[\d.]+/g) ?? [];
  return `rgba(${r}, ${g}, ${b}, ${alpha})`;
}

/** How a curve is drawn, so that colour is not all that tells curves apart. */
export interface Look {
  /** Number of a colour. */
  colour: number;
  dash: number[];
  width: number;
}

const DASHES = [[], [7, 3], [2, 3], [10, 3, 2, 3]];
const PIN_COLOURS = [3, 4, 2, 5, 1, 0];
const PIN_DASHES = [[5, 3], [2, 2], [9, 3, 2, 3], [12, 4]];

const pick = <T>(list: T[], k: number): T => list[k % list.length] as T;

export const liveLook = (k: number): Look => ({ colour: k % CURVES, dash: pick(DASHES, k), width: k ? 1.5 : 1.8 });

export const pinLook = (id: number): Look => ({
  colour: pick(PIN_COLOURS, id - 1),
  dash: pick(PIN_DASHES, id - 1),
  width: 1.3,
});
