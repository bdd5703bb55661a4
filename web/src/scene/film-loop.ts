// The loop beside the mechanism in a film: it grows with time.

import type { Palette } from "../lib/theme.ts";
import type { Run } from "../lib/types.ts";
import { portsOf } from "../plots/drawn.ts";
import { drawPicture } from "../plots/drawing.ts";
import { isOpen, pictureOf } from "../plots/loops.tsx";
import { boxOf, type Picture } from "../plots/picture.ts";
import { share } from "../plots/scale.ts";

/** Radius of the point that moves [px]. */
const DOT = 5;

/** The loop of a run that a film shows: its stroke over temperature, else the first one; null if nothing is a loop. */
export function chooseLoop(run: Run): Picture | null {
  const open = run.loops.filter((loop) => isOpen(run, loop));
  const loop = open.find(({ key }) => key === "stroke") ?? open[0];
  return loop ? pictureOf(run, loop, portsOf(run), []) : null;
}

/** A picture with its curves up to a row. */
export const upTo = (picture: Picture, row: number): Picture => ({
  ...picture,
  curves: picture.curves.flatMap((curve) => {
    const [first, last] = curve.part ?? [0, curve.x.length - 1];
    return first < row ? [{ ...curve, part: [first, Math.min(last, row)], arrows: false }] : [];
  }),
});

/** Draw a loop up to a row into a frame of a size, with its point. */
export function drawLoop(pen: CanvasRenderingContext2D, picture: Picture, row: number, width: number, height: number, colours: Palette): void {
  drawPicture(pen, upTo(picture, row), width, height, colours);
  const box = boxOf(picture, width, height, false);
  for (const mark of picture.marks ?? []) {
    pen.fillStyle = colours.curves[mark.colour] ?? colours.ink;
    pen.beginPath();
    pen.arc(box.left + share(picture.x, Number(mark.x[row])) * box.width, box.top + (1 - share(picture.y, Number(mark.y[row]))) * box.height, DOT, 0, 2 * Math.PI);
    pen.fill();
  }
}
