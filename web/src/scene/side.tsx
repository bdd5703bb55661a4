// The mechanism from the side, as lines: where there is no WebGL.

import type { SceneData, Shape } from "../lib/types.ts";
import type { Motion } from "./motion.ts";
import { digits } from "../lib/numbers.ts";
import { drawnAt, lengthOf, type Cut } from "./cuts.ts";
import { css, type Rgb } from "./tint.ts";

const WIDTH = 100;
const BODIES = ["weight", "pulley", "rotor", "object", "cylinder", "motor"];

/** How wide a line is, in hundredths of the picture. */
function stroke(shape: Shape, unit: number): number {
  if (shape.kind === "wire") return 0.7;
  if (shape.kind === "tether") return 0.25;
  if (shape.kind === "plate") return 0.6;
  return Math.max(2 * shape.size * unit, 0.5);
}

export function Side(props: { motion: Motion; time: number; colour: (port: string) => Rgb; label: string }) {
  const { motion, time } = props;
  motion.at(time);
  const { data } = motion;
  const unit = WIDTH / motion.extent;
  // bodies reach beyond the points on which they are drawn
  const margin = 6 + unit * Math.max(0, ...data.shapes.filter(({ kind }) => BODIES.includes(kind)).map(({ size }) => size));
  const [left, top] = [motion.low[0], motion.high[2]];
  const wide = (motion.high[0] - left) * unit + 2 * margin;
  const high = (top - motion.low[2]) * unit + 2 * margin;
  const spot = (shape: number, k: number): [number, number] => {
    const at = (motion.starts[shape] ?? 0) + 3 * k;
    return [((motion.places[at] ?? 0) - left) * unit + margin, (top - (motion.places[at + 2] ?? 0)) * unit + margin];
  };
  const line = Math.max(0, data.shapes.findIndex(({ kind }) => kind === "wire"));
  /** Where a cut crosses the first wire. */
  const placeBreak = (cut: Cut): [number, number] => {
    const middle = drawnAt(motion.cuts, cut.axis, 0.5 * (cut.low + cut.high));
    const [x, y] = spot(line, 0);
    return cut.axis === 0 ? [(middle - left) * unit + margin, y] : [x, (top - middle) * unit + margin];
  };
  return (
    <div class="scene-flat">
    <svg class="scene-side" viewBox={`0 0 ${wide} ${high}`} role="img" aria-label={props.label}>
      {data.shapes.map((shape, k) => (
        <Outline key={shape.name} shape={shape} data={data} unit={unit} spot={(i) => spot(k, i)} colour={props.colour} slack={!!shape.port && motion.slack(shape.port, time)} />
      ))}
      {motion.cuts.map((cut) => (
        <Break key={`${cut.axis} ${cut.low}`} cut={cut} at={placeBreak(cut)} />
      ))}
    </svg>
    </div>
  );
}

/** A break of a long line, and what it leaves out. */
function Break({ cut, at: [x, y] }: { cut: Cut; at: [number, number] }) {
  const turn = cut.axis === 0 ? `rotate(90 ${x} ${y})` : "";
  return (
    <g class="side-break">
      <path d={`M${x - 1.6} ${y + 0.1} l3.2 -1.2 v1.4 l-3.2 1.2 z`} transform={turn} />
      <text x={x + 3} y={y + (cut.axis === 0 ? -10 : 1.2)}>{digits(1e3 * lengthOf(cut), 3)} mm not drawn</text>
    </g>
  );
}

interface OutlineProps {
  shape: Shape;
  data: SceneData;
  unit: number;
  spot: (k: number) => [number, number];
  colour: (port: string) => Rgb;
  slack: boolean;
}

function Outline({ shape, unit, spot, colour, slack }: OutlineProps) {
  const points = Array.from({ length: shape.count }, (_, k) => spot(k));
  const [x, y] = points[0] ?? [0, 0];
  const size = shape.size * unit;
  const kind = `side-${shape.kind}`;
  if (shape.kind === "object") return <circle class={kind} cx={x} cy={y} r={size} />;
  if (shape.kind === "weight") return <rect class={kind} x={x - size} y={y} width={2 * size} height={2 * size} />;
  if (["pulley", "rotor", "joint"].includes(shape.kind)) return <circle class={kind} cx={x} cy={y} r={size} />;
  const paint = shape.port ? { stroke: css(colour(shape.port)) } : {};
  const line = points.map((point) => point.map((value) => value.toFixed(2)).join()).join(" ");
  const dashes = slack || shape.kind === "spring" ? { "stroke-dasharray": "1.2 0.8" } : {};
  return <polyline class={kind} points={line} stroke-width={stroke(shape, unit)} style={paint} {...dashes} />;
}
