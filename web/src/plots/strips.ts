// The bands of a phase diagram: their lines and the names of these.

import { FAMILY, setStroke, type Sheet } from "./drawing.ts";
import type { Strip } from "./picture.ts";

/** So near [px] are lines whose names would lie on each other. */
const [ALIKE_X, ALIKE_Y] = [18, 12];

/** The lines of a strip, each with its name; lines that lie on each other have their names side by side. */
export function drawSides(sheet: Sheet, strip: Strip, taken: [number, number][]): void {
  const { pen, x, y, colours, box } = sheet;
  const names: { text: string; px: number; py: number }[] = [];
  for (const side of strip.sides) {
    setStroke(sheet, { colour: strip.colour, dash: side.dash, width: 1 });
    pen.beginPath();
    side.x.forEach((v, i) => pen.lineTo(x(v), y(side.y[i] ?? 0)));
    pen.stroke();
    pen.setLineDash([]);
    const [px, py] = placeName(sheet, side);
    const last = names.at(-1);
    if (last && Math.abs(last.px - px) < ALIKE_X && Math.abs(last.py - py) < ALIKE_Y) last.text += ` ${side.name}`;
    else names.push({ text: side.name, px, py });
  }
  pen.fillStyle = colours.curves[strip.colour] ?? colours.ink;
  for (const { text, px, py } of names) {
    const own = text.split(" ");
    const wide = NAME * own.length;
    const left = px + wide < box.left + box.width ? px : px - wide - 14; // on the other side of its line
    let top = py;
    while (taken.some(([otherX, otherY]) => Math.abs(otherX - left) < ALIKE_X * own.length && Math.abs(otherY - top) < ALIKE_Y)) top += ALIKE_Y + 1;
    own.forEach((name, k) => {
      taken.push([left + NAME * k, top]);
      writeName(pen, name, left + NAME * k, top);
    });
  }
}

/** Room for the name of a line [px]. */
const NAME = 21;

/** Where the name of a line of a strip stands: where the line leaves the chart or ends. */
function placeName({ box, x, y }: Sheet, side: Strip["sides"][number]): [number, number] {
  const [level, right] = [box.top + 14, box.left + box.width - 28];
  const flat = side.y.length > 1 && Math.abs(y(side.y[0] ?? 0) - y(side.y.at(-1) ?? 0)) < ALIKE_Y && Math.abs(y(side.y[0] ?? 0) - y(side.y[1] ?? 0)) < ALIKE_Y;
  let [px, py] = [x(side.x[0] ?? 0), y(side.y[0] ?? 0) - 4];
  if (flat) return [Math.max(px, box.left) + 4, py];
  for (let i = 1; i < side.x.length; i++) {
    const [ax, ay, bx, by] = [x(side.x[i - 1] ?? 0), y(side.y[i - 1] ?? 0), x(side.x[i] ?? 0), y(side.y[i] ?? 0)];
    const edge = bx > ax ? (right - ax) / (bx - ax) : 1;
    const part = Math.min(1, ay > by ? (ay - level) / (ay - by) : 1, edge);
    [px, py] = [ax + part * (bx - ax) + 7, Math.max(level, ay + part * (by - ay) + (part < 1 ? 0 : 10))];
    if (part < 1) break;
  }
  return [px, py];
}

function writeName(pen: Sheet["pen"], name: string, px: number, py: number): void {
  const [head = "", index = ""] = name.split("_");
  const letter = head === "sigma" ? "σ" : head;
  pen.font = `italic 12px ${FAMILY}`;
  pen.textAlign = "left";
  pen.textBaseline = "alphabetic";
  pen.fillText(letter, px, py);
  const wide = pen.measureText(letter).width;
  pen.font = `italic 9px ${FAMILY}`;
  pen.fillText(index, px + wide, py + 3);
}
