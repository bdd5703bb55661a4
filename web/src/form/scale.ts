// Positions of a slider and the values they stand for, in the unit that is shown.

import { digits, readComma, toShown } from "../lib/numbers.ts";
import type { NumberNode, SliderRange } from "./types.ts";

export const POSITIONS = 200;

/** How many digits of a number are shown; what is written has seldom more. */
const SHOWN = 7;

/** 1, 2 or 5 times a power of ten, at most so large. */
function nice(size: number): number {
  const power = 10 ** Math.floor(Math.log10(size));
  const share = size / power;
  return (share >= 5 ? 5 : share >= 2 ? 2 : 1) * power;
}

const clean = (value: number): number => Number(value.toPrecision(SHOWN));

interface Ends {
  low: number;
  high: number;
}

const ends = (node: NumberNode, slider: SliderRange): Ends => ({ low: toShown(slider.low, node), high: toShown(slider.high, node) });

/** The value, in the shown unit, at a position. */
export function valueAt(node: NumberNode, slider: SliderRange, position: number): number {
  const share = position / POSITIONS;
  const { low, high } = ends(node, slider);
  if (share <= 0) return clean(low);
  if (share >= 1) return clean(high);
  const exact = slider.log ? low * (high / low) ** share : low + share * (high - low);
  if (slider.whole) return Math.round(exact);
  if (slider.log) return Number(exact.toPrecision(3));
  const step = nice((high - low) / POSITIONS);
  return Math.min(high, Math.max(low, clean(Math.round(exact / step) * step)));
}

/** The position of a value in the shown unit. */
export function positionOf(node: NumberNode, slider: SliderRange, value: number): number {
  const { low, high } = ends(node, slider);
  const share = slider.log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(POSITIONS * Math.min(1, Math.max(0, share)));
}

/** A value in the shown unit, a few thousandths of its size further. */
export function stepped(value: number, steps: number, node: NumberNode): number {
  const slider = node.slider;
  if (slider?.whole) return value + steps;
  const size = value !== 0 ? Math.abs(value) : slider ? Math.abs(toShown(slider.high, node) - toShown(slider.low, node)) : 1;
  return clean(value + steps * 10 ** (Math.floor(Math.log10(size)) - 2));
}

/** A number of a form as text without its unit; empty for one that is not there. */
export function written(node: NumberNode): string {
  if (node.value === null || node.unlimited) return "";
  return digits(toShown(node.value, node), SHOWN);
}

/** What is sent for a value in the shown unit. */
export const quantity = (node: NumberNode, value: number): string | number => (node.display_unit ? `${value} ${node.display_unit}` : value);

const BARE = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

/** What is sent for what was typed: a bare number is in the shown unit, all else the server reads. */
export function typed(node: NumberNode, text: string): string | number {
  const trimmed = readComma(text.trim());
  if (!BARE.test(trimmed)) return trimmed;
  // a number beyond all floats is refused as it was typed
  return Number.isFinite(Number(trimmed)) ? quantity(node, Number(trimmed)) : `${trimmed} ${node.display_unit}`.trim();
}
