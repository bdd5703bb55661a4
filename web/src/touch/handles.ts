// What a dragged body changes, by the kind of the mechanism: a number of the document, and how it grows.

import { listNumbers } from "../engine/inputs.ts";
import { flattenTable, readToml } from "../engine/toml.ts";
import type { Scenario } from "../engine/types.ts";

export interface Handle {
  /** Number that is changed. */
  path: string;
  /** What it is, in words. */
  words: string;
  /** Kinds of shapes by which it is held. */
  shapes: string[];
  /** Where a drag makes it larger: x, y, z up. */
  toward: [number, number, number];
  /** 1 if more of it loads the element more, -1 if less. */
  loads: 1 | -1;
}

export const HANDLES: Record<string, Handle> = {
  "dead-weight": { path: "mechanism.mass", words: "Weight", shapes: ["weight"], toward: [0, 0, -1], loads: 1 },
  "bias-spring": { path: "mechanism.preload", words: "Preload of the spring", shapes: ["spring", "slider"], toward: [1, 0, 0], loads: 1 },
  finger: { path: "mechanism.extension", words: "Extension of the spring", shapes: ["fingertip"], toward: [1, 0, 1], loads: 1 },
  "antagonistic-pulley": { path: "mechanism.moment", words: "Moment on the pulley", shapes: ["pulley"], toward: [0, 0, -1], loads: 1 },
  lever: { path: "mechanism.mass", words: "Weight on the lever", shapes: ["weight"], toward: [0, 0, -1], loads: 1 },
  "parallel-platform": { path: "mechanism.mass", words: "Mass of the plate", shapes: ["plate"], toward: [0, 0, -1], loads: 1 },
};

/** A handle as it is used: with the range in which it goes, and how it is shown. */
export interface Load extends Handle {
  value: number;
  low: number;
  high: number;
  /** SI. */
  unit: string;
  how: { display_unit: string; factor: number; offset: number };
}

/** What a mechanism of a kind is held by; null if by nothing. */
export const handleOf = (kind: string): Handle | null => (Object.hasOwn(HANDLES, kind) ? HANDLES[kind]! : null);

/** The kind of the mechanism that a document names. */
export function kindOf(text: string): string {
  const found = flattenTable(readToml(text));
  return (found.get("mechanism.kind") ?? found.get("mechanism") ?? "").replace(/^["']|["']$/g, "");
}

/** By what the mechanism of a scenario is held, as its numbers are now; null if by nothing that the page can change. */
export function findLoad(scenario: Scenario, text: string, changes: Record<string, number>): Load | null {
  const handle = handleOf(kindOf(text));
  const control = scenario.controls.find((one) => one.path === handle?.path);
  const node = listNumbers(scenario.form.sections).find((one) => one.path === handle?.path);
  if (!handle || !control || !node) return null;
  const { low, high } = control;
  return { ...handle, value: changes[handle.path] ?? control.value, low, high, unit: node.unit && node.unit !== "1" ? node.unit : "", how: { display_unit: node.display_unit, factor: node.factor, offset: node.offset } };
}

/** Its value after a drag from a value, in a mechanism of a size [m]: across it goes the whole range. */
export function dragLoad(held: Load, from: number, moved: readonly [number, number, number], extent: number): number {
  const length = Math.hypot(...held.toward);
  const along = held.toward.reduce((sum, part, k) => sum + part * moved[k]!, 0) / length;
  return clampLoad(held, from + (along / extent) * (held.high - held.low));
}

export const clampLoad = ({ low, high }: Load, value: number): number => Math.min(Math.max(value, low), high);
