// One chart: a picture on a canvas; over it the time line, moving points, and the values under the pointer. Every chart
// of the bench is this one: it zooms, is looked at by pointer and keys, and is saved.

import { effect, useSignal } from "@preact/signals";
import { useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { palette } from "../lib/theme.ts";
import { cursor, row } from "../state/run.ts";
import { drawPicture } from "./drawing.ts";
import { foundSpot, stepFrom, type Found } from "./hover.ts";
import { boxOf, type Box, type Picture } from "./picture.ts";
import { pointing } from "./pointing.ts";
import { Saving } from "./saving.tsx";
import { share, type Scale } from "./scale.ts";

export interface ChartProps {
  picture: Picture;
  /** [px]; as tall as its place if left out. */
  height?: number;
  /** What it shows, for those who do not see it. */
  about: string;
  /** x is the time: a line stands at the cursor. */
  timed?: boolean;
  /** The x axis has no numbers: another chart below has them. */
  bare?: boolean;
  /** What arrow keys do on it, for those who do not see it; they belong to what is around it if empty. */
  keys?: string;
  /** A place was clicked, or what is there was reached by keys. */
  onPick?: (x: number, y: number, found: Found | null) => void;
  onLook?: (found: Found | null) => void;
  /** A part of x was dragged over; it is zoomed to if left out. */
  onSelect?: (from: number, to: number) => void;
  /** Takes over what keys do. */
  onKey?: (event: KeyboardEvent) => void;
  /** Zoom that is shared with other charts: all of x, and what sets the part. */
  shared?: { whole: Scale; zoom: (part: Scale | null) => void };
}

const KEYS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const FAST = 10;

/** Charts that are out of sight are drawn after so long a rest: those in sight do not wait for them [ms]. */
const REST = 250;

interface Size {
  width: number;
  height: number;
}

/** Puts a picture onto a canvas, as sharp as the screen is. */
function paint(canvas: HTMLCanvasElement, picture: Picture, { width, height }: Size, bare: boolean): void {
  const dense = devicePixelRatio || 1;
  const [wide, high] = [Math.round(width * dense), Math.round(height * dense)];
  if (canvas.width !== wide) canvas.width = wide;
  if (canvas.height !== high) canvas.height = high;
  const pen = canvas.getContext("2d");
  if (!pen || !width || !height) return;
  pen.setTransform(dense, 0, 0, dense, 0, 0);
  pen.clearRect(0, 0, width, height);
  drawPicture(pen, picture, width, height, palette.peek(), bare);
}

export function Chart(props: ChartProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const over = useRef<HTMLDivElement>(null);
  const part = useSignal<{ x: Scale; y: Scale } | null>(null);
  const { picture, shared, keys = "Arrow keys show the values along the curve." } = props;
  const shown = useMemo(() => (part.value && !shared ? { ...picture, ...labelled(picture, part.value) } : picture), [picture, part.value, shared]);
  const now = useRef({ props, shown, at: null as Found | null });
  Object.assign(now.current, { props, shown });

  /** Shows what was found; null for nothing. */
  const look = (found: Found | null): void => {
    now.current.at = found;
    if (over.current) tellOf(over.current, now.current.shown, found);
    now.current.props.onLook?.(found);
  };
  const zoom = (to: { x: Scale; y: Scale } | null): void => {
    if (shared) shared.zoom(to && to.x);
    else part.value = to;
  };
  // what is known of its place, so that a picture asks for no layout
  const size = useRef<Size>({ width: 0, height: 0 });
  const box = useRef<Box>({ left: 0, top: 0, width: 0, height: 0 });
  const seen = useRef(true);
  const waiting = useRef(0);
  const redraw = (): void => {
    const [sheet, top] = [canvas.current, over.current];
    clearTimeout(waiting.current);
    waiting.current = 0;
    if (!sheet || !top || !size.current.width) return;
    const { props: p, shown: what } = now.current;
    paint(sheet, what, size.current, !!p.bare);
    layOver();
    mark(top, what, box.current, !!p.timed, cursor.peek(), row.peek());
  };
  /** Lay what answers the pointer over the curves. */
  const layOver = (): void => {
    const next = boxOf(now.current.shown, size.current.width, size.current.height, now.current.props.bare);
    for (const side of ["left", "top", "width", "height"] as const) if (next[side] !== box.current[side]) over.current!.style[side] = `${next[side]}px`;
    box.current = next;
  };
  const drawSoon = (): void => {
    clearTimeout(waiting.current);
    if (seen.current) redraw();
    else waiting.current = window.setTimeout(redraw, REST);
  };

  useLayoutEffect(() => {
    const [sheet, top] = [canvas.current, over.current];
    if (!sheet || !top) return;
    const stop = [
      effect(() => (palette.value, drawSoon())),
      effect(() => mark(top, now.current.shown, box.current, !!now.current.props.timed, cursor.value, row.value)),
      pointing({
        over: top, select: top.querySelector<HTMLElement>(".chart-select")!, props: () => now.current.props, shown: () => now.current.shown,
        whole: () => ({ x: now.current.props.shared?.whole ?? now.current.props.picture.x, y: now.current.props.picture.y }),
        zoom: (to) => latest.current(to), look: (found) => found !== now.current.at && look(found),
      }),
    ];
    const sized = new ResizeObserver(() => {
      const { top: above, bottom } = sheet.getBoundingClientRect();
      size.current = { width: sheet.clientWidth, height: sheet.clientHeight };
      seen.current = above < innerHeight && bottom > 0;
      if (size.current.width) layOver();
      drawSoon();
    });
    const near = new IntersectionObserver((entries) => {
      seen.current = entries.at(-1)!.isIntersecting;
      if (seen.current && waiting.current) redraw();
    });
    sized.observe(sheet);
    near.observe(sheet);
    return () => {
      stop.forEach((end) => end());
      sized.disconnect();
      near.disconnect();
      clearTimeout(waiting.current);
    };
  }, []);
  const latest = useRef(zoom);
  latest.current = zoom;
  useLayoutEffect(drawSoon, [shown, props.bare]);

  const press = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (props.onKey) return props.onKey(event);
    if (event.key === "Escape") look(null);
    const direction = KEYS[event.key];
    if (!direction) return;
    event.preventDefault();
    const ring = shown.rings?.[0];
    const fast = event.shiftKey ? FAST : 1;
    const found = stepFrom(shown, ring ? foundSpot(shown, ring) : now.current.at, [direction[0] * fast, direction[1]]);
    if (!found) return;
    look(found);
    if (found.spot) props.onPick?.(found.x, found.y, found);
  };
  const words = keys && { role: "application" as const, tabIndex: 0, "aria-label": `${props.about}. ${keys}`, "aria-roledescription": "chart" };
  return (
    <div class="chart" style={props.height ? { height: `${props.height}px` } : undefined}>
      <canvas ref={canvas} {...(keys ? { "aria-hidden": true } : { role: "img", "aria-label": props.about })} />
      <div class="chart-over" ref={over} {...words} onKeyDown={keys ? press : undefined}>
        <div class="chart-select" hidden />
        <div class="chart-marks" />
        <div class="chart-tip" aria-live="polite" hidden />
      </div>
      <div class="chart-corner">
        {part.value && !shared && (
          <button type="button" class="quiet small" onClick={() => zoom(null)}>
            Show all
          </button>
        )}
        <Saving about={props.about} picture={shown} size={() => ({ width: canvas.current?.clientWidth ?? 0, height: canvas.current?.clientHeight ?? 0 })} />
      </div>
    </div>
  );
}

/** A part of a picture keeps the picture's labels, whatever it is part of. */
const labelled = ({ x, y }: Picture, part: { x: Scale; y: Scale }): { x: Scale; y: Scale } => ({
  x: { ...part.x, label: x.label }, y: { ...part.y, label: y.label },
});

/** Put time line and moving points where they belong now. */
function mark(over: HTMLElement, picture: Picture, { width, height }: Size, timed: boolean, time: number, at: number): void {
  const home = over.querySelector<HTMLElement>(".chart-marks");
  if (!home) return;
  const marks = picture.marks ?? [];
  const count = marks.length + (timed ? 1 : 0);
  while (home.children.length > count) home.lastChild?.remove();
  while (home.children.length < count) home.append(document.createElement("i"));
  const colours = palette.peek();
  marks.forEach((point, k) => {
    const dot = home.children[k] as HTMLElement;
    const [x, y] = [share(picture.x, point.x[at] as number) * width, (1 - share(picture.y, point.y[at] as number)) * height];
    dot.className = "dot";
    dot.hidden = !Number.isFinite(x + y);
    dot.style.transform = `translate(${x}px, ${y}px)`;
    dot.style.background = colours.curves[point.colour] ?? colours.ink;
  });
  if (timed) {
    const line = home.lastChild as HTMLElement;
    line.className = "time-line";
    line.style.transform = `translateX(${share(picture.x, time) * width}px)`;
  }
}

/** Distance of what is told from what it is told of [px]. */
const APART = 12;

/** Tell of what was found, beside it. */
function tellOf(over: HTMLElement, picture: Picture, found: Found | null): void {
  const tip = over.querySelector<HTMLElement>(".chart-tip");
  if (!tip) return;
  const [width, height] = [over.clientWidth, over.clientHeight];
  const [x, y] = found ? [share(picture.x, found.x), 1 - share(picture.y, found.y)] : [NaN, NaN];
  tip.hidden = !(x >= -0.01 && x <= 1.01);
  if (!found || tip.hidden) return;
  tip.replaceChildren(
    ...found.lines.map(({ words, colour }) => {
      const line = document.createElement("span");
      line.textContent = words;
      if (colour !== undefined && colour >= 0) line.style.borderColor = palette.peek().curves[colour] ?? "";
      return line;
    }),
  );
  const [px, wide] = [x * width, tip.offsetWidth];
  tip.style.left = `${px + APART + wide <= width ? px + APART : Math.max(px - APART - wide, -over.offsetLeft)}px`;
  tip.style.top = `${Math.max(0, Math.min(Number.isFinite(y) ? y : 1, 1) * height - 10)}px`;
}
