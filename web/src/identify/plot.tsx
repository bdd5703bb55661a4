// A plot over time (or runs): lines and dots, bands behind them, colours of the theme.

import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { palette } from "../lib/theme.ts";

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

const axis = (label: string, size: number): uPlot.Axis => ({
  label,
  labelSize: 18,
  labelGap: 0,
  size,
  gap: 3,
  font: "11px system-ui, sans-serif",
  labelFont: "12px system-ui, sans-serif",
  stroke: palette.peek().soft,
  grid: { stroke: palette.peek().line, width: 1 },
  ticks: { stroke: palette.peek().line, width: 1 },
});

function series(line: Line): uPlot.Series {
  const { curves, panel } = palette.peek();
  const stroke = curves[line.colour] ?? "";
  return {
    label: line.label,
    stroke,
    width: line.dots ? 0 : 2,
    spanGaps: false,
    ...(line.dashed ? { dash: [6, 4] } : {}),
    points: line.dots ? { show: true, size: line.hollow ? 6 : 4, fill: line.hollow ? panel : stroke, stroke, width: line.hollow ? 1.5 : 0 } : { show: false },
    ...(line.dots ? { paths: () => null } : {}),
  };
}

function shade(plot: uPlot, bands: Band[]): void {
  const { ctx, bbox } = plot;
  ctx.save();
  for (const band of bands) {
    const left = Math.max(plot.valToPos(band.from, "x", true), bbox.left);
    const right = Math.min(plot.valToPos(band.to, "x", true), bbox.left + bbox.width);
    if (right <= left) continue;
    ctx.globalAlpha = band.chosen ? 0.22 : 0.1;
    ctx.fillStyle = palette.peek().accent;
    ctx.fillRect(left, bbox.top, right - left, bbox.height);
    ctx.globalAlpha = 1;
    ctx.strokeStyle = palette.peek().accent;
    ctx.strokeRect(left, bbox.top, right - left, bbox.height);
  }
  ctx.restore();
}

function made(at: HTMLElement, props: PlotProps, latest: { current: PlotProps }): uPlot {
  const options: uPlot.Options = {
    width: Math.max(at.clientWidth, 120),
    height: props.height ?? 200,
    legend: { show: false },
    cursor: { drag: { x: Boolean(props.onSelect), y: false, setScale: false }, y: false, points: { show: false } },
    scales: {
      x: { time: false, ...(props.range ? { range: () => latest.current.range ?? [0, 1] } : {}) },
      y: props.logarithmic ? { distr: 3 } : {},
    },
    axes: [axis(props.xLabel, 30), axis(props.yLabel, 56)],
    series: [{}, ...props.lines.map(series)],
    hooks: {
      drawClear: [(plot) => shade(plot, latest.current.bands ?? [])],
      setSelect: [
        (plot) => {
          const { left, width } = plot.select;
          if (width < 3) return;
          latest.current.onSelect?.(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
          plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        },
      ],
    },
  };
  return new uPlot(options, data(props), at);
}

const data = (props: PlotProps): uPlot.AlignedData => [props.x, ...props.lines.map((line) => line.values)];

export function Plot(props: PlotProps) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const latest = useRef(props);
  latest.current = props;
  const shape = JSON.stringify([props.yLabel, props.xLabel, props.height, props.lines.map((line) => line.label), !props.range]);
  useEffect(() => {
    const at = place.current;
    if (!at) return;
    const build = (): void => {
      plot.current?.destroy();
      plot.current = made(at, latest.current, latest);
    };
    const leave = palette.subscribe(build);
    const watcher = new ResizeObserver(() => plot.current?.setSize({ width: Math.max(at.clientWidth, 120), height: latest.current.height ?? 200 }));
    watcher.observe(at);
    return () => {
      watcher.disconnect();
      leave();
      plot.current?.destroy();
      plot.current = null;
    };
  }, [shape]);
  useEffect(() => plot.current?.setData(data(props)), [props.x, ...props.lines.map((line) => line.values)]);
  useEffect(() => plot.current?.redraw(false), [JSON.stringify([props.bands, props.range])]);
  return <div class="identify-plot" ref={place} role="img" aria-label={props.label} />;
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
