// Samples of how a curve is drawn.

import { palette } from "../lib/theme.ts";
import type { Look } from "./palette.ts";

export function Swatch({ look }: { look: Look }) {
  return (
    <svg class="swatch" width="26" height="8" aria-hidden="true">
      <line x1="1" y1="4" x2="25" y2="4" stroke={palette.value.curves[look.colour]} stroke-width={look.width + 0.6} stroke-dasharray={look.dash.join(" ")} />
    </svg>
  );
}
