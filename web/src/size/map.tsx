// Force over stroke: where wires do, filled in while one looks, and the wish as a point that can be dragged.

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { digits, readComma } from "../lib/numbers.ts";
import { Message } from "../ui/message.tsx";
import { beginMap, fields, mapped, mapping, wish } from "./state.ts";
import type { Cell } from "./types.ts";
import { Work } from "./work.tsx";

const LEFT = 52;
const TOP = 8;
const WIDE = 560;
const HIGH = 250;

interface Axes {
  forces: number[];
  strokes: number[];
}

/** Place of a number on an axis of equally spaced logarithms, in cells; the middle of the first is 0.5. */
function placeOn(levels: number[], value: number): number {
  const [first = 1, second = 2] = levels;
  return 0.5 + Math.log(value / first) / Math.log(second / first);
}

function valueOn(levels: number[], place: number): number {
  const [first = 1, second = 2] = levels;
  const inside = Math.min(Math.max(place, 0), levels.length);
  return first * (second / first) ** (inside - 0.5);
}

const SI: Record<string, number> = { N: 1, mN: 1e-3, kN: 1e3, kgf: 9.80665, m: 1, cm: 1e-2, mm: 1e-3, um: 1e-6, "µm": 1e-6 };

/** A typed quantity in SI; NaN where only the server can read it. */
function convertQuantity(text: string | undefined): number {
  const found = /^\s*([\d.,]+(?:e[+-]?\d+)?)\s*(\S+)\s*$/i.exec(readComma(text ?? ""));
  return found ? Number(found[1]) * (SI[found[2] ?? ""] ?? NaN) : NaN;
}

function nameCell(cell: Cell, axes: Axes): string {
  const where = `${digits(axes.forces[cell.column], 3)} N over ${digits(1e3 * (axes.strokes[cell.row] ?? 0), 3)} mm`;
  if (!cell.best) return `${where}: none. ${cell.reason}`;
  const { size, alloy, count } = cell.best;
  return `${where}: ${cell.does} wires meet the request, ${cell.robust} of them robust; best ${count} × ${size}, ${alloy} °C`;
}

function Cells({ cells, axes }: { cells: Cell[]; axes: Axes }) {
  const [w, h] = [WIDE / axes.forces.length, HIGH / axes.strokes.length];
  return (
    <>
      {axes.forces.map((_, column) =>
        axes.strokes.map((_, row) => <rect key={`${column} ${row}`} class="map-field" x={LEFT + column * w} y={TOP + row * h} width={w - 1} height={h - 1} />),
      )}
      {cells.map((cell) => {
        const [x, y] = [LEFT + cell.column * w, TOP + HIGH - (cell.row + 1) * h];
        const kind = !cell.best ? "none" : cell.robust ? "robust" : "frail";
        return (
          <g key={`${cell.column} ${cell.row}`} class={`map-cell ${kind}`}>
            <title>{nameCell(cell, axes)}</title>
            <rect x={x} y={y} width={w - 1} height={h - 1} />
            <text x={x + w / 2} y={y + h / 2 + 4}>{cell.best ? `${cell.best.count}×${cell.best.size.replace(/ mm$/, "")}` : "×"}</text>
          </g>
        );
      })}
    </>
  );
}

function Ticks({ axes }: { axes: Axes }) {
  const [w, h] = [WIDE / axes.forces.length, HIGH / axes.strokes.length];
  return (
    <g class="map-ticks">
      {axes.forces.map((force, k) => k % 2 === 0 && <text key={force} x={LEFT + (k + 0.5) * w} y={TOP + HIGH + 15} text-anchor="middle">{digits(force, 3)}</text>)}
      {axes.strokes.map((stroke, k) => <text key={stroke} x={LEFT - 5} y={TOP + HIGH - (k + 0.5) * h + 4} text-anchor="end">{digits(1e3 * stroke, 3)}</text>)}
      <text x={LEFT + WIDE / 2} y={TOP + HIGH + 31} text-anchor="middle">force, N</text>
      <text x={12} y={TOP + HIGH / 2} text-anchor="middle" transform={`rotate(-90 12 ${TOP + HIGH / 2})`}>stroke, mm</text>
    </g>
  );
}

const STEPS: Record<string, [number, number]> = { ArrowLeft: [-0.25, 0], ArrowRight: [0.25, 0], ArrowUp: [0, 0.25], ArrowDown: [0, -0.25] };

function Wish({ axes }: { axes: Axes }) {
  const dragged = useSignal<[number, number] | null>(null);
  const host = useRef<SVGGElement>(null);
  const asked: [number, number] = [
    placeOn(axes.forces, convertQuantity(fields.value["force"])),
    placeOn(axes.strokes, convertQuantity(fields.value["stroke"])),
  ];
  const now = dragged.value ?? asked;
  if (!now.every(Number.isFinite)) return null;
  const [w, h] = [WIDE / axes.forces.length, HIGH / axes.strokes.length];
  const [force, stroke] = [valueOn(axes.forces, now[0]), valueOn(axes.strokes, now[1])];
  const place = (event: PointerEvent): [number, number] => {
    const svg = host.current?.ownerSVGElement;
    const matrix = svg?.getScreenCTM()?.inverse();
    if (!matrix) return now;
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
    return [(point.x - LEFT) / w, (TOP + HIGH - point.y) / h];
  };
  const take = ([column, row]: [number, number]): void => {
    dragged.value = null;
    void wish(valueOn(axes.forces, column), valueOn(axes.strokes, row));
  };
  const press = (event: KeyboardEvent): void => {
    const step = STEPS[event.key];
    if (step) {
      event.preventDefault();
      dragged.value = [now[0] + step[0], now[1] + step[1]];
    } else if (event.key === "Enter" && dragged.value) take(dragged.value);
    else if (event.key === "Escape") dragged.value = null;
  };
  const words = `${digits(force, 3)} N over ${digits(1e3 * stroke, 3)} mm`;
  const [x, y] = [LEFT + Math.min(Math.max(now[0], 0), axes.forces.length) * w, TOP + HIGH - Math.min(Math.max(now[1], 0), axes.strokes.length) * h];
  return (
    <g
      ref={host} class="map-wish" tabIndex={0} role="slider" aria-label="Request: force over stroke" aria-valuetext={words} aria-valuenow={force}
      transform={`translate(${x} ${y})`} onKeyDown={press}
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        dragged.value = place(event);
      }}
      onPointerMove={(event) => dragged.value && (dragged.value = place(event))}
      onPointerUp={() => dragged.value && take(dragged.value)}
      onPointerCancel={() => (dragged.value = null)}
    >
      <circle r="16" class="map-grip" />
      <circle r="6" />
      <text y={y < 40 ? 28 : -14} text-anchor={x > LEFT + WIDE - 60 ? "end" : x < LEFT + 60 ? "start" : "middle"}>{words}</text>
    </g>
  );
}

export function WishMap() {
  const found = mapped.value;
  const busy = mapping.job.value?.state === "running";
  return (
    <section class="panel stack size-map" aria-label="Map of force and stroke">
      <div class="row">
        <h2>Other forces and strokes</h2>
        {!busy && (
          <button type="button" onClick={() => void beginMap()}>
            {found ? "Map around this request" : "Draw the map"}
          </button>
        )}
      </div>
      <Work watched={mapping} what="Simulating forces and strokes" />
      {found ? (
        <>
          <svg viewBox={`0 0 ${LEFT + WIDE + 8} ${TOP + HIGH + 38}`} role="group" aria-label="Map: each field shows the best number and diameter (mm) of wires">
            <Cells cells={found.cells} axes={found} />
            <Ticks axes={found} />
            <Wish axes={found} />
          </svg>
          <p class="small soft">
            <span class="map-key robust" /> meets the request, also at +10 K and +20 % load <span class="map-key frail" /> meets the request <span class="map-key none" /> no wire.
            Each field shows the best wires, number × diameter in mm. Drag the point, or use the arrow keys and Enter.
          </p>
        </>
      ) : (
        !busy && <Message kind="note">The map simulates 45 pairs of force and stroke around the request, starting at the request. It takes about 20 s of computing time.</Message>
      )}
    </section>
  );
}
