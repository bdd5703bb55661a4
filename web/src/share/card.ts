// A picture to send: the mechanism with its key numbers.

import type { Palette } from "../lib/theme.ts";

export interface Card {
  title: string;
  about: string;
  numbers: [name: string, value: string][];
  /** A line below everything; empty for none. */
  note: string;
}

/** Size of pictures that pages and messengers show beside a link [px]. */
export const [WIDE, HIGH] = [1200, 630];
const [MARGIN, LEFT] = [48, 640];
const FAMILY = "system-ui, sans-serif";

type Pen = CanvasRenderingContext2D;

/** Write a line, smaller where it would be longer than its room. */
function write(pen: Pen, text: string, x: number, y: number, room: number, size: number, style = ""): void {
  let fitted = size;
  do pen.font = `${style} ${fitted}px ${FAMILY}`;
  while (pen.measureText(text).width > room && (fitted -= 1) > 10);
  pen.fillText(text, x, y);
}

/** Draw a picture into a frame, as large as it fits. */
function place(pen: Pen, picture: CanvasImageSource & { width: number; height: number }, x: number, y: number, wide: number, high: number): void {
  const scale = Math.min(wide / picture.width, high / picture.height);
  const [w, h] = [scale * picture.width, scale * picture.height];
  pen.drawImage(picture, x + 0.5 * (wide - w), y + 0.5 * (high - h), w, h);
}

export function paintCard(pen: Pen, card: Card, picture: (CanvasImageSource & { width: number; height: number }) | null, colours: Palette): void {
  pen.fillStyle = colours.panel;
  pen.fillRect(0, 0, WIDE, HIGH);
  pen.textBaseline = "alphabetic";
  pen.fillStyle = colours.ink;
  write(pen, card.title, MARGIN, 84, WIDE - 2 * MARGIN, 46, "bold");
  pen.fillStyle = colours.soft;
  write(pen, card.about, MARGIN, 122, WIDE - 2 * MARGIN, 22);
  if (picture) place(pen, picture, MARGIN, 150, LEFT - MARGIN, 380);
  const [x, room] = [LEFT + 40, 0.5 * (WIDE - LEFT - 40 - MARGIN)];
  card.numbers.slice(0, 8).forEach(([name, value], k) => {
    const [left, top] = [x + (k % 2) * room, 190 + Math.floor(k / 2) * 92];
    pen.fillStyle = colours.soft;
    write(pen, name, left, top, room - 16, 20);
    pen.fillStyle = colours.ink;
    write(pen, value, left, top + 42, room - 16, 36, "bold");
  });
  pen.fillStyle = colours.accent;
  write(pen, card.note || "martensite: simulate shape-memory-alloy actuators", MARGIN, HIGH - 40, WIDE - 2 * MARGIN, card.note ? 30 : 22, card.note ? "bold" : "");
}

/** The same as text, with an address. */
export const writeCard = (card: Card, link: string): string =>
  [card.title, ...(card.note ? [card.note] : []), ...card.numbers.map(([name, value]) => `${name}: ${value}`), link].join("\n");
