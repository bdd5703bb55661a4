// Hysteresis loops: one quantity over another, heated parts and cooled parts told apart.

import { useMemo } from "preact/hooks";
import type { Loop, Run } from "../lib/types.ts";
import { axisLabel, beside, planeHeight, portsOf, shownColumn, type Beside } from "./drawn.ts";
import { before } from "../state/run.ts";
import { LoopChart } from "./loop.tsx";
import { liveLook, type Look } from "./palette.ts";
import type { Curve, Mark, Picture } from "./picture.ts";
import { around } from "./scale.ts";
import { Swatch } from "./swatch.tsx";

const HEIGHT = 196;

/** How parts are drawn by sense: thick where heated, thin where cooled. */
export const SENSES: { sense: number; word: string; look: Look }[] = [
  { sense: 1, word: "heating", look: { colour: 1, dash: [], width: 2.4 } },
  { sense: -1, word: "cooling", look: { colour: 0, dash: [], width: 1.4 } },
  { sense: 0, word: "", look: { colour: 0, dash: [], width: 1.7 } },
];
const PLAIN = 2;

const lookOf = (sense: number): Look => (SENSES.find((one) => one.sense === sense) ?? SENSES[PLAIN]!).look;

/** The path of a port through a plane: in parts of one sense, or whole beside other ports. */
export function path(of: Run, port: string, x: string, y: string, number: number, several: boolean): Curve[] {
  const columns = { x: shownColumn(of, x), y: shownColumn(of, y) };
  if (several) return [{ ...columns, look: liveLook(number), arrows: true }];
  const parts = of.stretches[port] ?? [];
  return parts.map(([sense, first, last]) => ({ ...columns, look: lookOf(sense), part: [first, last], arrows: true }));
}

/** Paths of a pinned run through the same plane, if its units are the same. */
function pinnedPaths(one: Beside, loop: Loop, units: string): Curve[] {
  const same = one.run.loops.find((other) => other.key === loop.key);
  return portsOf(one.run).flatMap((port) => {
    const pair = same?.ports[port];
    return pair && unitsOf(one.run, pair) === units ? [{ x: shownColumn(one.run, pair[0]), y: shownColumn(one.run, pair[1]), look: one.look }] : [];
  });
}

const unitsOf = (of: Run, pair: string[]): string => pair.map((name) => of.outputs[name]?.display_unit).join();

export function pictureOf(of: Run, loop: Loop, ports: string[], pins: Beside[]): Picture | null {
  const pairs = ports.flatMap((port) => (loop.ports[port] ? [{ port, pair: loop.ports[port] }] : []));
  const first = pairs[0];
  if (!first) return null;
  const several = pairs.length > 1;
  const live = pairs.flatMap(({ port, pair: [x, y] }, k) => path(of, port, x, y, k, several));
  const under = pins.flatMap((one) => pinnedPaths(one, loop, unitsOf(of, first.pair)));
  const marks: Mark[] = pairs.map(({ pair: [x, y] }, k) => ({
    x: shownColumn(of, x), y: shownColumn(of, y), colour: several ? liveLook(k).colour : 1,
  }));
  const [x, y] = first.pair.map((name) => of.outputs[name]);
  if (!x || !y) return null;
  const all = [...live, ...under];
  return {
    x: around(axisLabel(x), all.map((curve) => curve.x)),
    y: around(axisLabel(y), all.map((curve) => curve.y)),
    curves: [...under, ...live],
    marks,
  };
}

function One({ of, loop, height }: { of: Run; loop: Loop; height: number }) {
  const pins = beside.value;
  const ports = portsOf(of);
  const picture = useMemo(() => pictureOf(of, loop, ports, pins), [of, loop, pins, ports.join()]);
  const pair = Object.values(loop.ports)[0];
  if (!picture || !pair) return null;
  const [x, y] = pair.map((name) => of.outputs[name]?.long_name.split(",")[0]);
  return <LoopChart title={`${y} – ${x}`} about={`${y} over ${x}`} picture={picture} height={height} />;
}

/** What thick and thin curves mean, or which port has which. */
export function Key({ of }: { of: Run }) {
  const ports = portsOf(of);
  if (!of.loops.length) return null;
  const entries =
    ports.length > 1
      ? ports.map((port, k) => ({ word: port, look: liveLook(k) }))
      : SENSES.filter(({ sense, word }) => word && of.stretches[ports[0] ?? ""]?.some((part) => part[0] === sense));
  return (
    <p class="key small soft">
      {entries.map(({ word, look }) => (
        <span key={word}>
          <Swatch look={look} /> {word}
        </span>
      ))}
    </p>
  );
}

/** Whether something happens along both axes: at one temperature there is no loop over it. */
export function isOpen(of: Run, loop: Loop): boolean {
  const varies = (name: string): boolean => {
    const column = of.columns[name] ?? [];
    const [low, high] = [column.reduce((a, b) => Math.min(a, b), Infinity), column.reduce((a, b) => Math.max(a, b), -Infinity)];
    return high - low > 1e-6 * Math.max(Math.abs(low), Math.abs(high));
  };
  return (loop.ports[portsOf(of)[0] ?? ""] ?? []).every(varies);
}

/** Beside the mechanism stands the first loop of which there is something to be seen; others are among the charts. */
export function Loops({ of, isBeside }: { of: Run; isBeside: boolean }) {
  const first = of.loops.find((loop) => isOpen(before.value ?? of, loop)) ?? of.loops[0]; // by hand it stays the same loop
  return (
    <>
      {of.loops.filter((loop) => (loop === first) === isBeside).map((loop) => (
        <One key={loop.key} of={of} loop={loop} height={isBeside ? planeHeight.value : HEIGHT} />
      ))}
    </>
  );
}
