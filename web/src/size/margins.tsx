// How much of each limit a wire uses: bars up to the limit, with numbers.

import { digits } from "../lib/numbers.ts";
import type { Margin } from "./types.ts";

const OVER = 1 + 1e-6;
const CLOSE = 0.9;

function Bar({ share, chosen }: Margin) {
  const style = { width: `${100 * Math.min(1, Math.max(0, share))}%` };
  return (
    <div class="margin-bar" aria-hidden="true">
      <div class={share > OVER ? "over" : share > CLOSE && !chosen ? "close" : ""} style={style} />
    </div>
  );
}

function words({ share, chosen }: Margin): string {
  const used = `${digits(100 * share, 3)} %`;
  if (share > OVER) return `${used}, not kept`;
  return chosen ? `${used}, by choice` : used;
}

export function Margins({ margins }: { margins: Margin[] }) {
  return (
    <table class="margins">
      <caption>Utilisation of each limit</caption>
      <thead>
        <tr>
          <th scope="col">limit</th>
          <th scope="col">used</th>
          <th scope="col">share</th>
          <th scope="col" aria-hidden="true" />
        </tr>
      </thead>
      <tbody>
        {margins.map((margin) => (
          <tr key={margin.name}>
            <th scope="row">{margin.name}</th>
            <td>
              {margin.used} of {margin.limit} {margin.unit}
            </td>
            <td>{words(margin)}</td>
            <td class="bar">
              <Bar {...margin} />
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
