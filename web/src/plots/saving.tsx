// What can be taken away of one chart: its picture for the screen or for print, and its numbers.

import { save } from "../lib/api.ts";
import { palette } from "../lib/theme.ts";
import { drawPicture } from "./drawing.ts";
import { Menu } from "./menu.tsx";
import type { Picture } from "./picture.ts";
import { writeNumbers } from "./table.ts";
import { VectorPen } from "./vector.ts";

/** The picture in SVG, on the ground of the theme. */
export function writeVector(picture: Picture, width: number, height: number, title: string): string {
  const pen = new VectorPen();
  pen.fillStyle = palette.peek().panel;
  pen.fillRect(0, 0, width, height);
  drawPicture(pen, picture, width, height, palette.peek());
  return pen.document(width, height, title);
}

const SHARP = 3;

function savePixels(picture: Picture, width: number, height: number, name: string): void {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width * SHARP, height * SHARP];
  const pen = canvas.getContext("2d");
  if (!pen) return;
  pen.scale(SHARP, SHARP);
  pen.fillStyle = palette.peek().panel;
  pen.fillRect(0, 0, width, height);
  drawPicture(pen, picture, width, height, palette.peek());
  canvas.toBlob((blob) => blob && save(`${name}.png`, blob));
}

export interface SavingProps {
  about: string;
  picture: Picture;
  /** As large as it is on the page, or a little larger. */
  size: () => { width: number; height: number };
}

/** Least size of a saved picture [px]. */
const [WIDE, HIGH] = [480, 240];

export function Saving({ about, picture, size }: SavingProps) {
  const name = about.replace(/[^\w.() -]+/g, "_").slice(0, 60);
  const large = (): [number, number] => [Math.max(size().width, WIDE), Math.max(size().height, HIGH)];
  return (
    <Menu name="⋯" about="Save this chart">
      <div class="stack">
        <button type="button" onClick={() => savePixels(picture, ...large(), name)}>
          Picture, PNG
        </button>
        <button type="button" onClick={() => save(`${name}.svg`, new Blob([writeVector(picture, ...large(), about)], { type: "image/svg+xml" }))}>
          Picture, SVG
        </button>
        <button type="button" onClick={() => save(`${name}.csv`, new Blob([writeNumbers(picture)], { type: "text/csv" }))}>
          Data, CSV
        </button>
      </div>
    </Menu>
  );
}
