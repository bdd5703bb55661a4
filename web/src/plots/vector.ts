// A pen that writes SVG: what `drawing.ts` draws on a canvas, as lines and words that can be scaled.

import type { Pen } from "./drawing.ts";

const two = (value: number): string => String(Math.round(value * 100) / 100);
const quote = (text: string): string => text.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);

const ANCHORS: Partial<Record<CanvasTextAlign, string>> = { center: "middle", right: "end" };
const LINES: Partial<Record<CanvasTextBaseline, string>> = { middle: "0.36em", top: "0.85em" };

export class VectorPen implements Pen {
  fillStyle: Pen["fillStyle"] = "black";
  strokeStyle: Pen["strokeStyle"] = "black";
  lineWidth = 1;
  lineJoin: CanvasLineJoin = "round";
  font = "12px sans-serif";
  textAlign: CanvasTextAlign = "left";
  textBaseline: CanvasTextBaseline = "alphabetic";
  globalAlpha = 1;
  private readonly parts: string[] = [];
  private path = "";
  private dash: number[] = [];
  private now = { transform: "", clip: "" };
  private readonly kept: { transform: string; clip: string }[] = [];
  private clips = 0;

  save = (): void => void (this.kept.push({ ...this.now }));
  restore = (): void => void (this.now = this.kept.pop() ?? this.now);
  translate = (x: number, y: number): void => void (this.now.transform += `translate(${two(x)} ${two(y)})`);
  rotate = (angle: number): void => void (this.now.transform += `rotate(${two((angle * 180) / Math.PI)})`);
  beginPath = (): void => void (this.path = "");
  moveTo = (x: number, y: number): void => void (this.path += `M${two(x)} ${two(y)}`);
  lineTo = (x: number, y: number): void => void (this.path += `${this.path ? "L" : "M"}${two(x)} ${two(y)}`);

  /** Whole circles only. */
  arc(x: number, y: number, radius: number): void {
    const r = two(radius);
    this.path += `M${two(x - radius)} ${two(y)}a${r} ${r} 0 1 0 ${two(2 * radius)} 0a${r} ${r} 0 1 0 ${two(-2 * radius)} 0`;
  }

  rect(x: number, y: number, width: number, height: number): void {
    this.path += `M${two(x)} ${two(y)}h${two(width)}v${two(height)}h${two(-width)}Z`;
  }

  clip(): void {
    this.clips += 1;
    const within = this.now.clip && ` clip-path="url(#${this.now.clip})"`;
    this.parts.push(`<clipPath id="part-${this.clips}"${within}><path d="${this.path}"/></clipPath>`);
    this.now.clip = `part-${this.clips}`;
  }

  setLineDash = (dash: Iterable<number>): void => void (this.dash = [...dash]);
  fill = (): void => void (this.add("path", `d="${this.path}" fill="${this.fillStyle as string}"`));

  stroke(): void {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    this.add("path", `d="${this.path}" fill="none" stroke="${this.strokeStyle as string}" stroke-width="${this.lineWidth}"${dash}`);
  }

  fillRect(x: number, y: number, width: number, height: number): void {
    this.add("rect", `x="${two(x)}" y="${two(y)}" width="${two(width)}" height="${two(height)}" fill="${this.fillStyle as string}"`);
  }

  fillText(text: string, x: number, y: number): void {
    const [style = "", size = "12", family = ""] = /^(italic )?([\d.]+)px (.*)$/.exec(this.font)?.slice(1) ?? [];
    const where = `x="${two(x)}" y="${two(y)}" dy="${LINES[this.textBaseline] ?? "0"}" text-anchor="${ANCHORS[this.textAlign] ?? "start"}"`;
    const look = `fill="${this.fillStyle as string}" font-size="${size}" font-family="${quote(family)}"${style && ' font-style="italic"'}`;
    this.add("text", `${where} ${look}`, quote(text));
  }

  /** About as wide as letters are. */
  measureText(text: string): TextMetrics {
    const size = Number(/([\d.]+)px/.exec(this.font)?.[1] ?? 12);
    return { width: 0.56 * size * text.length } as TextMetrics;
  }

  private add(name: string, attributes: string, inside = ""): void {
    const { transform, clip } = this.now;
    const more = [transform && `transform="${transform}"`, clip && `clip-path="url(#${clip})"`, this.globalAlpha < 1 && `opacity="${this.globalAlpha}"`];
    this.parts.push(`<${[name, attributes, ...more].filter(Boolean).join(" ")}>${inside}</${name}>`);
  }

  /** The whole document. */
  document(width: number, height: number, title: string): string {
    const head = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${two(width)} ${two(height)}" width="${two(width)}" height="${two(height)}">`;
    return `${head}<title>${quote(title)}</title>${this.parts.join("\n")}</svg>\n`;
  }
}
