// Colours of elements by temperature or martensite fraction, and what their scale reads.

import type { Run } from "../lib/types.ts";
import { valueAt } from "./motion.ts";

export type Quantity = "temperature" | "martensite_fraction";
export type Rgb = [number, number, number];

export const NAMES: Record<Quantity, string> = { temperature: "Temperature", martensite_fraction: "Martensite fraction" };

/** Cold to hot; austenite to martensite. Told apart by lightness too. */
export const SCALES: Record<Quantity, Rgb[]> = {
  temperature: [[38, 84, 164], [92, 141, 190], [226, 172, 70], [214, 96, 30], [168, 24, 24]],
  martensite_fraction: [[214, 96, 30], [196, 168, 120], [20, 104, 170]],
};

export const css = (colour: Rgb): string => `rgb(${colour.map(Math.round).join(" ")})`;

export function tint(quantity: Quantity, share: number): Rgb {
  const scale = SCALES[quantity];
  const place = Math.min(Math.max(share, 0), 1) * (scale.length - 1);
  const k = Math.min(Math.floor(place), scale.length - 2);
  const [a, b] = [scale[k] as Rgb, scale[k + 1] as Rgb];
  return a.map((value, i) => value + (place - k) * ((b[i] ?? 0) - value)) as Rgb;
}

/** Lowest and highest value of all elements in a run, in SI; a fraction goes from 0 to 1. */
export function span(run: Run, quantity: Quantity): [number, number] {
  if (quantity === "martensite_fraction") return [0, 1];
  let [low, high] = [Infinity, -Infinity];
  for (const names of Object.values(run.scene.ports)) {
    for (const value of run.columns[names[quantity]] ?? []) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  return high - low > 1 ? [low, high] : [low - 0.5, low + 0.5];
}

/** Value of an element at a time, in SI. */
export const valueOf = (run: Run, port: string, quantity: Quantity, time: number): number =>
  valueAt(run.times, run.columns[run.scene.ports[port]?.[quantity] ?? ""], time);

export const colourOf = (run: Run, port: string, quantity: Quantity, time: number, [low, high]: [number, number]): Rgb =>
  tint(quantity, (valueOf(run, port, quantity, time) - low) / (high - low));
