// Words beside things: names and values, written over the picture where there is room.

import { Vector3, type Camera } from "three";

export interface Word {
  text: string;
  at: Vector3;
  kind: "name" | "mass" | "cut" | "force" | "hover";
  /** Right of its place, not above it: that of a part that stands upright. */
  beside?: boolean;
}

export interface Written {
  text: string;
  x: number;
  y: number;
  kind: Word["kind"];
}

const HIGH = 18;
/** Height of a line, and width of a letter, about [px]. */
const LINE = 17;
const LETTER = 7.2;
/** Distance of words beside a part that stands [px]: marks of breaks are as wide. */
const ASIDE = 12;
const ABOVE: Record<Word["kind"], number> = { name: -16, mass: 0, cut: -22, force: 0, hover: -20 };

/** Where words stand in a picture of a size [px]; what would lie on another is left out, the last ones first. */
export function arrangeLabels(words: Word[], camera: Camera, width: number, height: number): Written[] {
  const found: (Written & { wide: number })[] = [];
  const spot = new Vector3();
  for (const { text, at: place, kind, beside: aside } of words) {
    spot.copy(place).project(camera);
    if (spot.z > 1 || Math.abs(spot.x) > 1.02 || Math.abs(spot.y) > 1.02) continue;
    const wide = Math.max(...text.split("\n").map((line) => line.length)) * LETTER + 10;
    const x = Math.min(Math.max((0.5 + 0.5 * spot.x) * width + (aside ? 0.5 * wide + ASIDE : 0), 0.5 * wide), width - 0.5 * wide);
    const lines = text.split("\n").length;
    const at = (0.5 - 0.5 * spot.y) * height;
    // what is pointed at has its words above it, or below where there is no room
    const box = LINE * lines + 10;
    const beside = at > box + 16 ? at - 14 - 0.5 * box : at + 22 + 0.5 * box;
    const y = kind === "hover" ? beside : Math.min(Math.max(at + (aside ? 0 : ABOVE[kind]), 12), height - 12);
    const clear = found.every((other) => Math.abs(other.x - x) > 0.5 * (other.wide + wide) || Math.abs(other.y - y) > HIGH * lines);
    if (clear || kind === "hover") found.push({ text, x, y, kind, wide });
  }
  return found;
}

/** Elements that hold the words, used again and again. */
export class Labels {
  private readonly spans: HTMLSpanElement[] = [];

  constructor(private readonly host: HTMLElement) {}

  write(words: Written[]): void {
    while (this.spans.length < words.length) {
      const span = document.createElement("span");
      this.spans.push(span);
      this.host.append(span);
    }
    this.spans.forEach((span, k) => {
      const word = words[k];
      span.hidden = !word;
      if (!word) return;
      if (span.textContent !== word.text) span.textContent = word.text;
      span.className = `scene-label small ${word.kind}`;
      span.style.transform = `translate(${word.x.toFixed(1)}px, ${word.y.toFixed(1)}px) translate(-50%, -50%)`;
    });
  }
}

/** The same words in a picture that is taken away. */
export function paintWords(context: CanvasRenderingContext2D, words: Written[], ink: string, back: string, scale: number): void {
  context.font = `${12 * scale}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 4 * scale;
  for (const { text, x, y } of words) {
    text.split("\n").forEach((line, k) => {
      const at: [number, number] = [x * scale, (y + 15 * k) * scale];
      context.strokeStyle = back;
      context.strokeText(line, ...at);
      context.fillStyle = ink;
      context.fillText(line, ...at);
    });
  }
}
