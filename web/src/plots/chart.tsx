// One chart: uPlot keeps axes, grid and scales; the picture is drawn between them. The chart is made
// once and then shown other pictures; time line and moving points are elements above the canvas.

import { effect } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { digits } from "../lib/numbers.ts";
import { cursor, row } from "../state/run.ts";
import { drawAbove, drawBelow, type Picture } from "./picture.ts";
import { pointing } from "./pointing.ts";
import { palette } from "../lib/theme.ts";

export interface ChartProps {
  picture: Picture;
  height: number;
  /** What it shows, for those who do not see it. */
  about: string;
  /** x is the time: a line stands at the cursor. */
  timed?: boolean;
  /** The x axis has no numbers: another chart below has them. */
  bare?: boolean;
  onPick: (x: number, y: number) => void;
  onZoom: (x: [number, number], y: [number, number]) => void;
  onReset: () => void;
}

const Y_AXIS = 56;
const X_AXIS = 26;
const LABEL = 16;
const FONT = "11.5px system-ui, sans-serif";
const LABEL_FONT = "12px system-ui, sans-serif";

/** The picture as uPlot needs it: it only has to know that there is something. */
const corners = ({ xLimits: [a, b], yLimits: [c, d] }: Picture): uPlot.AlignedData => [
  [a, b],
  [c, d],
];

function axis(label: () => string, side: number, bare = false): uPlot.Axis {
  const numbers = (_: uPlot, splits: number[]): string[] => splits.map((v) => (bare ? "" : digits(v, 6)));
  return {
    side,
    stroke: () => palette.peek().soft,
    grid: { stroke: () => palette.peek().line, width: 1 },
    ticks: { stroke: () => palette.peek().line, width: 1, size: bare ? 0 : 4 },
    font: FONT,
    labelFont: LABEL_FONT,
    size: side === 3 ? Y_AXIS - LABEL : bare ? 4 : X_AXIS,
    space: side === 3 ? 20 : 60,
    gap: 4,
    values: numbers,
    ...(bare ? {} : { label: label as unknown as string, labelSize: LABEL, labelGap: 0 }),
  };
}

export function Chart(props: ChartProps) {
  const place = useRef<HTMLDivElement>(null);
  const now = useRef(props);
  const chart = useRef<uPlot | null>(null);
  now.current = props;

  useLayoutEffect(() => {
    const home = place.current;
    if (!home) return;
    const picture = (): Picture => now.current.picture;
    const overlay = document.createElement("div");
    overlay.className = "chart-marks";
    const u = new uPlot(
      {
        width: home.clientWidth || 300,
        height: props.height,
        padding: [6, 10, props.bare ? 2 : 0, 0],
        legend: { show: false },
        cursor: { show: false },
        scales: {
          x: { time: false, range: () => picture().xLimits },
          y: { range: () => picture().yLimits },
        },
        series: [{}, { paths: () => null, points: { show: false } }],
        axes: [axis(() => picture().xLabel, 2, props.bare), axis(() => picture().yLabel, 3)],
        hooks: {
          drawClear: [(self) => drawBelow(self, picture(), palette.peek())],
          draw: [
            (self) => {
              drawAbove(self, picture(), palette.peek());
              mark(self, overlay, now.current, cursor.peek(), row.peek());
            },
          ],
        },
      },
      corners(props.picture),
      home,
    );
    chart.current = u;
    u.over.append(overlay);
    const stop = [
      effect(() => (palette.value, u.redraw(false))),
      effect(() => mark(u, overlay, now.current, cursor.value, row.value)),
      pointing(u, now),
    ];
    const seen = new ResizeObserver(() => {
      const wide = home.clientWidth;
      if (wide && wide !== u.width) u.setSize({ width: wide, height: now.current.height });
    });
    seen.observe(home);
    return () => {
      stop.forEach((end) => end());
      seen.disconnect();
      u.destroy();
      chart.current = null;
    };
  }, []);

  useLayoutEffect(() => {
    const u = chart.current;
    if (!u) return;
    u.batch(() => {
      u.setData(corners(props.picture));
      u.redraw();
    });
  }, [props.picture]);

  useLayoutEffect(() => {
    const u = chart.current;
    if (u && u.height !== props.height) u.setSize({ width: u.width, height: props.height });
  }, [props.height]);

  return <div class="chart" ref={place} role="img" aria-label={props.about} style={{ height: `${props.height}px` }} />;
}

/** Put time line and moving points where they belong now. */
function mark(u: uPlot, overlay: HTMLElement, { picture, timed }: ChartProps, time: number, at: number): void {
  const marks = picture.marks ?? [];
  const count = marks.length + (timed ? 1 : 0);
  while (overlay.children.length > count) overlay.lastChild?.remove();
  while (overlay.children.length < count) overlay.append(document.createElement("i"));
  const colours = palette.peek();
  marks.forEach((point, k) => {
    const dot = overlay.children[k] as HTMLElement;
    const x = u.valToPos(point.x[at] as number, "x");
    const y = u.valToPos(point.y[at] as number, "y");
    dot.className = "dot";
    dot.hidden = !Number.isFinite(x + y);
    dot.style.transform = `translate(${x}px, ${y}px)`;
    dot.style.background = colours.curves[point.colour] ?? colours.ink;
  });
  if (timed) {
    const line = overlay.lastChild as HTMLElement;
    line.className = "time-line";
    line.style.transform = `translateX(${u.valToPos(time, "x")}px)`;
  }
}
