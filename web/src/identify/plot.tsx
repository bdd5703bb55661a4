// A chart of a log: measured and modelled over time, with the records shaded.

import { useMemo } from "preact/hooks";
import { Chart } from "../plots/chart.tsx";
import type { Picture } from "../plots/picture.ts";
import { around } from "../plots/scale.ts";

export interface Line {
  label: string;
  values: (number | null)[];
  /** Number of the curve's colour. */
  colour: number;
  dots?: boolean;
  dashed?: boolean;
  /** Dots that are rings. */
  hollow?: boolean;
}

export interface Band {
  from: number;
  to: number;
  chosen: boolean;
}

export interface PlotProps {
  /** What the plot shows, for who cannot see it. */
  label: string;
  x: number[];
  xLabel: string;
  yLabel: string;
  lines: Line[];
  height?: number;
  logarithmic?: boolean;
  bands?: Band[];
  range?: [number, number];
  /** A stretch was drawn with the mouse. */
  onSelect?: (from: number, to: number) => void;
}

const known = (values: (number | null)[]): Float64Array => Float64Array.from(values, (value) => value ?? NaN);

function pictureOf({ x, xLabel, yLabel, lines, logarithmic = false, range }: PlotProps): Picture {
  const columns = lines.map((line) => known(line.values));
  return {
    x: range ? { label: xLabel, low: range[0], high: range[1] } : around(xLabel, [x], 0),
    y: around(yLabel, columns, 0.07, [], logarithmic),
    along: true,
    curves: lines.map(({ label, colour, dots, dashed, hollow }, k) => ({
      x, y: columns[k]!, name: label, look: { colour, dash: dashed ? [6, 4] : [], width: 2 },
      ...(dots ? { dots: hollow ? "ring" : "full" } : {}),
    })),
  };
}

export function Plot(props: PlotProps) {
  const { label, x, lines, bands = [], range, height = 200, onSelect } = props;
  const base = useMemo(() => pictureOf(props), [x, range?.join(), props.yLabel, props.xLabel, ...lines.map((line) => line.values)]);
  const picture = useMemo<Picture>(
    () => ({ ...base, shades: bands.map(({ from, to, chosen }) => ({ begin: from, end: to, strong: chosen, word: "", calm: true })) }),
    [base, JSON.stringify(bands)],
  );
  return <Chart picture={picture} height={height} about={label} {...(onSelect ? { onSelect } : {})} />;
}

/** What the colours of a plot mean. */
export function Key({ lines }: { lines: Pick<Line, "label" | "colour" | "dots" | "dashed" | "hollow">[] }) {
  return (
    <p class="identify-key small">
      {lines.map((line) => (
        <span key={line.label}>
          <svg width="26" height="10" aria-hidden="true">
            {line.dots ? (
              [4, 13, 22].map((x) => <circle key={x} cx={x} cy={5} r={2.5} stroke={`var(--curve-${line.colour})`} fill={line.hollow ? "none" : `var(--curve-${line.colour})`} />)
            ) : (
              <line x1={1} x2={25} y1={5} y2={5} stroke={`var(--curve-${line.colour})`} stroke-width={2.5} stroke-dasharray={line.dashed ? "6 4" : undefined} />
            )}
          </svg>{" "}
          {line.label}
        </span>
      ))}
    </p>
  );
}
