// A picture of runs over two scales, that is looked at with pointer or keys.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { palette } from "../lib/theme.ts";
import { boxOf, draw, edges, place, type Picture, type Spot } from "./draw.ts";
import { GRADIENT } from "./colours.ts";
import { ticks, tickText, share, type Dim } from "./scale.ts";
import { chosen } from "./shown.ts";
import { openRun } from "./bench.ts";

const NEAR = 24;
const KEYS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** Place among cells with such limits; -1 outside. */
const between = (limits: number[], at: number): number => (at < 0 || at >= 1 ? -1 : limits.filter((limit) => limit <= at).length - 1);

/** The spot under a pointer. */
function hit(picture: Picture, width: number, height: number, x: number, y: number): Spot | null {
  const box = boxOf(width, height);
  if (picture.cells) {
    const ix = between(edges(picture.x, picture.cells.xs), (x - box.left) / box.width);
    const iy = between(edges(picture.y, picture.cells.ys), 1 - (y - box.top) / box.height);
    return ix < 0 || iy < 0 ? null : (picture.spots[ix * picture.cells.ys.length + iy] ?? null);
  }
  let [found, nearest]: [Spot | null, number] = [null, NEAR];
  for (const spot of picture.spots) {
    const [left, top] = place(picture, box, spot);
    const apart = Math.hypot(left - x, top - y);
    if (apart < nearest) [found, nearest] = [spot, apart];
  }
  return found;
}

/** The next spot in a direction: the neighbouring cell, or the next point along a scale. */
function step(picture: Picture, from: Spot | undefined, [dx, dy]: [number, number]): Spot | null {
  const { spots } = picture;
  if (!from) return spots[0] ?? null;
  if (picture.cells) return spots.find((one) => one.ix === (from.ix ?? 0) + dx && one.iy === (from.iy ?? 0) + dy) ?? null;
  const along = (spot: Spot): number => (dx ? dx * spot.x : dy * spot.y);
  const here = along(from);
  let next: Spot | null = null;
  for (const spot of spots) if (along(spot) > here && (!next || along(spot) < along(next))) next = spot;
  return next;
}

export function ColourBar({ dim }: { dim: Dim }) {
  return (
    <div class="sweep-bar" role="img" aria-label={`Colour: ${dim.label} from ${tickText(dim.low)} to ${tickText(dim.high)}`}>
      <span class="sweep-bar-label">{dim.label}</span>
      <div class="sweep-bar-colours" style={{ background: GRADIENT }}>
        {ticks(dim, 5).map((tick) => (
          <span key={tick} style={{ bottom: `${100 * share(dim, tick)}%` }}>
            {tickText(tick)}
          </span>
        ))}
      </div>
    </div>
  );
}

export function Plane({ picture, label, onLook }: { picture: Picture; label: string; onLook: (row: number | null) => void }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const over = useSignal<number | null>(null);
  const marked = [chosen.value, over.value].filter((row) => row !== null);
  const colours = palette.value;
  const redraw = (): void => void (canvas.current && draw(canvas.current, picture, marked, colours));
  useEffect(redraw);
  const latest = useRef(redraw);
  latest.current = redraw;
  useEffect(() => {
    const sizes = new ResizeObserver(() => latest.current());
    if (canvas.current) sizes.observe(canvas.current);
    return () => sizes.disconnect();
  }, []);
  const look = (row: number | null): void => {
    over.value = row;
    onLook(row);
  };
  const under = (event: PointerEvent | MouseEvent): Spot | null => {
    const from = canvas.current?.getBoundingClientRect();
    return from ? hit(picture, from.width, from.height, event.clientX - from.left, event.clientY - from.top) : null;
  };
  const press = (event: KeyboardEvent): void => {
    const direction = KEYS[event.key];
    if (event.key === "Enter" && chosen.value !== null) void openRun(chosen.value);
    if (event.key === "Escape") chosen.value = null;
    if (!direction) return;
    event.preventDefault();
    const found = step(picture, picture.spots.find((spot) => spot.row === chosen.value), direction);
    if (found) chosen.value = found.row;
  };
  return (
    <div class="sweep-plane">
      <div
        class="sweep-canvas" tabIndex={0} role="application" aria-roledescription="picture"
        aria-label={`${label}. Arrow keys move from run to run, Enter opens one in the bench.`} onKeyDown={press}
      >
        <canvas
          ref={canvas} onPointerMove={(event) => look(under(event)?.row ?? null)} onPointerLeave={() => look(null)}
          onClick={(event) => (chosen.value = under(event)?.row ?? null)}
        />
      </div>
      {picture.colour && <ColourBar dim={picture.colour} />}
    </div>
  );
}
