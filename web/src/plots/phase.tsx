// The phase diagram: transformation bands of the law, and the path of the run through them.

import { useMemo } from "preact/hooks";
import type { Band, Output, Run } from "../lib/types.ts";
import { axisLabel, beside, portsOf, shownColumn, shownValues, type Beside } from "./drawn.ts";
import { LoopChart } from "./loop.tsx";
import { path } from "./loops.tsx";
import { liveLook } from "./palette.ts";
import type { Numbers, Picture, Strip } from "./picture.ts";
import { around } from "./scale.ts";
import { Drawn } from "../touch/drawn.tsx";

/** Bands of what heating does in the colour of heating, others in that of cooling. */
const colourOf = (band: Band): number => (band.process === "reverse" ? 1 : 0);

function strip(band: Band, x: Output, y: Output): Strip {
  const sides = [band.start, band.finish].map((line, k) => ({
    x: Array.from(shownValues(line.temperature, x)),
    y: Array.from(shownValues(line.stress, y)),
    name: line.name,
    dash: k === 0 ? [5, 3] : [],
  }));
  return { colour: colourOf(band), sides };
}

function pinnedPath(one: Beside): { x: Numbers; y: Numbers; look: Beside["look"] }[] {
  return portsOf(one.run).flatMap((port) => {
    const at = one.run.phase.ports[port];
    return at ? [{ x: shownColumn(one.run, at.x), y: shownColumn(one.run, at.y), look: one.look }] : [];
  });
}

function pictureOf(of: Run, pins: Beside[], drawn: string[]): { picture: Picture; sentence: string } | null {
  const first = of.phase.ports[drawn[0] ?? ""];
  const diagram = first && of.phase.diagrams[first.diagram];
  const x = first && of.outputs[first.x];
  const y = first && of.outputs[first.y];
  if (!first || !diagram || !x || !y) return null;
  const ports = drawn.filter((port) => of.phase.ports[port]?.diagram === first.diagram);
  const several = ports.length > 1;
  const strips = diagram.bands.map((band) => strip(band, x, y));
  const own = ports.map((port) => of.phase.ports[port]!);
  const live = ports.flatMap((port, k) => path(of, port, own[k]!.x, own[k]!.y, k, several));
  const under = pins.flatMap(pinnedPath);
  const all = [...live, ...under];
  const bottoms = strips.flatMap((one) => one.sides.map((side) => (side.y[0] === side.y[1] ? side.x[1] : side.x[0]) ?? NaN));
  const top = diagram.highest * y.factor + y.offset;
  const picture: Picture = {
    x: around(axisLabel(x), all.map((curve) => curve.x), 0.05, bottoms.filter(Number.isFinite)),
    y: around(axisLabel(y), all.map((curve) => curve.y), 0.02, [0, top]),
    curves: [...under, ...live],
    strips,
    marks: own.map((at, k) => ({ x: shownColumn(of, at.x), y: shownColumn(of, at.y), colour: several ? liveLook(k).colour : 1 })),
  };
  return { picture, sentence: diagram.sentence };
}

export function Phase({ of, height }: { of: Run; height: number }) {
  const pins = beside.value;
  const ports = portsOf(of);
  const found = useMemo(() => pictureOf(of, pins, ports), [of, pins, ports.join()]);
  if (!found) return null;
  return (
    <>
      <Drawn>
      <LoopChart
        title="Phase diagram"
        about="Phase diagram: stress over temperature, with the transformation bands of the law; a band begins at its dashed line"
        picture={found.picture}
        height={height}
      />
      </Drawn>
      {found.sentence && <p class="soft small">{found.sentence}</p>}
    </>
  );
}
