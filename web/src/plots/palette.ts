// How curves are drawn, so that they are told apart.

import { CURVES } from "../lib/theme.ts";

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
