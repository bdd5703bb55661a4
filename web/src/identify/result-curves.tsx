// Measured beside modelled, and what is left, for every record and output.

import { difference, toShown } from "../lib/numbers.ts";
import { printed } from "./number.tsx";
import { Key, Plot } from "./plot.tsx";
import type { Compared, Outcome } from "./types.ts";

const PANELS = 8;
const FITTED = { label: "measured, fitted", colour: 0, dots: true };
const HELD = { label: "measured, held out", colour: 3, dots: true, hollow: true };
const MODEL = { label: "model", colour: 1 };
const REST = { label: "model less measured", colour: 2, dots: true };

function Pair({ one }: { one: Compared }) {
  const measured = one.measured.map((value) => (value === null ? null : toShown(value, one)));
  const rest = one.measured.map((value, k) => (value === null ? null : difference((one.model[k] ?? 0) - value, one)));
  const unit = one.display_unit ? ` [${printed(one.display_unit)}]` : "";
  const { axis } = one;
  // a loop without times is drawn over what drives it, in the order of that, as dots
  const order = one.times.map((_, k) => k);
  if (axis) order.sort((a, b) => (axis.values[a] ?? 0) - (axis.values[b] ?? 0));
  const sorted = <T,>(values: T[]): T[] => (axis ? order.map((k) => values[k]!) : values);
  const x = axis ? order.map((k) => toShown(axis.values[k] ?? 0, axis)) : one.times;
  const over = axis ? `${axis.name} [${printed(axis.display_unit)}]` : "time [s]";
  return (
    <div>
      <Plot
        label={`${one.long_name || one.output} of ${one.record}, measured and modelled`}
        x={x}
        xLabel={`${over}, ${one.record}`}
        yLabel={one.output + unit}
        lines={[
          { ...FITTED, values: sorted(measured.map((value, k) => (one.held[k] ? null : value))) },
          { ...HELD, values: sorted(measured.map((value, k) => (one.held[k] ? value : null))) },
          { ...MODEL, ...(axis ? { dots: true } : {}), values: sorted(one.model.map((value) => toShown(value, one))) },
        ]}
        height={230}
      />
      <Plot label={`Residuals of ${one.output} of ${one.record}`} x={x} xLabel={over} yLabel={`residual${unit}`} lines={[{ ...REST, values: sorted(rest) }]} height={150} />
    </div>
  );
}

export function ResultCurves({ found }: { found: Outcome }) {
  return (
    <section class="panel" aria-label="Measured and modelled">
      <Key lines={[FITTED, HELD, MODEL, REST]} />
      <div class="identify-panels">
        {found.rows.slice(0, PANELS).map((one) => (
          <Pair key={`${one.record} ${one.output}`} one={one} />
        ))}
      </div>
      {found.rows.length > PANELS && <p class="soft small">{found.rows.length - PANELS} more are not drawn; the report has them.</p>}
    </section>
  );
}
