// What the colours of the elements say, with numbers, and the values at the cursor.

import { digits, toShown } from "../lib/numbers.ts";
import type { Run } from "../lib/types.ts";
import { css, NAMES, SCALES, span, valueOf, type Quantity } from "./tint.ts";

/** So many elements have their values beside the picture; those of more are in a list to open. */
const FEW = 3;

export function writeValue(run: Run, quantity: Quantity | "force" | "stress", value: number): string {
  const first = Object.values(run.scene.ports)[0];
  const how = run.outputs[first?.[quantity] ?? ""];
  if (!how) return digits(value);
  const unit = how.display_unit === "degC" ? "°C" : how.display_unit;
  const shown = toShown(value, how);
  return `${digits(Math.abs(shown) < 1e-4 ? 0 : shown, 3)}${unit ? ` ${unit}` : ""}`;
}

export function Legend({ run, quantity }: { run: Run; quantity: Quantity }) {
  const [low, high] = span(run, quantity);
  const stops = SCALES[quantity].map(css).join(", ");
  const marks = [low, 0.5 * (low + high), high];
  return (
    <div class="scene-legend">
      <div class="scene-bar" style={{ background: `linear-gradient(to right, ${stops})` }} aria-hidden="true" />
      <div class="scene-marks small">
        {marks.map((value, k) => (
          <span key={k}>
            {writeValue(run, quantity, value)}
            {quantity === "martensite_fraction" && k === 0 ? " austenite" : ""}
          </span>
        ))}
      </div>
    </div>
  );
}

/** One element at the cursor, in words. */
export function told(run: Run, port: string, time: number, slack: boolean): string {
  const both: Quantity[] = ["temperature", "martensite_fraction"];
  const values = both.map((one) => `${one === "temperature" ? "" : "ξ "}${writeValue(run, one, valueOf(run, port, one, time))}`);
  return [...values, ...(slack ? ["slack"] : [])].join(", ");
}

export function Values({ run, time, slack }: { run: Run; time: number; slack: (port: string) => boolean }) {
  const ports = Object.keys(run.scene.ports);
  const list = (
    <ul class="scene-values small" aria-label="Elements at the cursor">
      {ports.map((port) => (
        <li key={port}>
          <span class="soft">{port.replaceAll("_", " ")}</span> {told(run, port, time, slack(port))}
        </li>
      ))}
    </ul>
  );
  if (ports.length <= FEW) return list;
  return (
    <details>
      <summary class="small">{ports.length} elements at the cursor</summary>
      {list}
    </details>
  );
}

export const nameOf = (quantity: Quantity): string => NAMES[quantity];
