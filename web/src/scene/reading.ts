// What the stage is told of a run at a time: colours, forces, and words about everything.

import { digits, toShown } from "../lib/numbers.ts";
import type { Palette } from "../lib/theme.ts";
import type { Kind, Run, Shape } from "../lib/types.ts";
import { writeValue } from "./legend.tsx";
import { valueAt, type Motion } from "./motion.ts";
import type { Colours } from "./materials.ts";
import type { Reading } from "./stage.ts";
import { colourOf, span, valueOf, type Quantity } from "./tint.ts";

const WHAT: Record<Kind, string> = {
  ground: "stands still", wall: "stands still", link: "rigid link", phalanx: "link of a finger", fingertip: "last link of a finger", beam: "strip that bends",
  bracket: "bracket", joint: "pin of a hinge", wire: "shape-memory wire", spring: "passive spring",
  tether: "thread that does not stretch", force: "force of contact", weight: "weight", slider: "what is moved", pulley: "pulley",
  cylinder: "what is gripped", motor: "motor", plate: "plate", palm: "palm", rotor: "unbalance", object: "joint",
};

/** Colours of the page for the stage. */
export function choosePaints(p: Palette): Colours {
  const [, , spring = p.soft, rotor = p.accent, , weight = p.soft] = p.curves;
  return { back: p.panel, ink: p.ink, soft: p.soft, line: p.line, spring, weight, rotor, accent: p.accent };
}

/** A wire that would not be seen is drawn thicker, and that is said. */
const THINNEST = 0.0042;

function thickness(shape: Shape, extent: number): string {
  if (!shape.diameter) return "";
  const times = (2 * THINNEST * extent) / shape.diameter;
  return `${digits(1000 * shape.diameter, 3)} mm thick${times > 1.05 && !shape.coil ? `, drawn ${digits(times, 2)} times thicker` : ""}`;
}

/** The output that is called like a shape, or the run's own if it moves. */
function output(now: Run, shape: Shape, time: number): string {
  const own = shape.name.replaceAll(" ", "_");
  const name = now.outputs[own] ? own : shape.still ? "" : now.coordinate;
  const how = now.outputs[name];
  if (!how) return "";
  const unit = how.display_unit ? ` ${how.display_unit}` : "";
  return `${name === own ? "" : `${how.long_name} `}${digits(toShown(valueAt(now.times, now.columns[name], time), how), 3)}${unit}`;
}

const moves = ["phalanx", "fingertip", "link", "beam", "slider", "weight", "pulley", "plate", "object", "motor"];

function words(now: Run, shape: Shape, time: number, motion: Motion, extent: number): string[] {
  const name = shape.name.replaceAll("_", " ");
  if (shape.port === undefined) {
    const known = moves.includes(shape.kind) ? output(now, shape, time) : "";
    return [name, shape.kind === name ? "" : WHAT[shape.kind] ?? "", known].filter((line, k) => k === 0 || line);
  }
  const columns = now.scene.ports[shape.port];
  const value = (quantity: Quantity): string => writeValue(now, quantity, valueOf(now, shape.port as string, quantity, time));
  const pull = (quantity: "force" | "stress"): string =>
    columns?.[quantity] ? writeValue(now, quantity, valueAt(now.times, now.columns[columns[quantity]], time)) : "";
  const slack = motion.slack(shape.port, time) ? "slack" : "";
  const state = [value("temperature"), `ξ ${value("martensite_fraction")}`, pull("force"), slack].filter(Boolean).join(", ");
  return [name, [shape.coil ? "shape-memory coil" : WHAT.wire, thickness(shape, extent)].filter(Boolean).join(", "), state];
}

/** By time, what is read of a run; elements are coloured by a quantity. */
export function makeReader(now: Run, quantity: Quantity, motion: Motion): (time: number) => Reading {
  const range = span(now, quantity);
  const columns = Object.values(now.scene.ports).map(({ force }) => now.columns[force] ?? []);
  const most = columns.reduce((found, column) => column.reduce((a, b) => Math.max(a, b), found), 0);
  return (time) => ({
    colour: (port) => colourOf(now, port, quantity, time, range),
    force: (port) => valueAt(now.times, now.columns[now.scene.ports[port]?.force ?? ""], time),
    most,
    words: (shape, extent) => words(now, shape, time, motion, extent),
  });
}
