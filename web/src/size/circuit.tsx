// The electronics of a wire that was found, drawn: supply, wires in series or parallel, transistor; and what each must bear.

import { digits, readComma } from "../lib/numbers.ts";
import { fields, fileName } from "./state.ts";
import type { Candidate } from "./types.ts";

const SPARE = 1.5;
/** Wires that are drawn; more are counted. */
const MOST = 4;

/** A zigzag for a wire from the left to the right. */
function Strand({ x, y, wide }: { x: number; y: number; wide: number }) {
  const teeth = Array.from({ length: 8 }, (_, k) => `${x + 8 + ((wide - 16) * (k + 0.5)) / 8},${y + (k % 2 ? 5 : -5)}`);
  return <polyline points={`${x},${y} ${x + 8},${y} ${teeth.join(" ")} ${x + wide - 8},${y} ${x + wide},${y}`} class="circuit-wire" />;
}

function Strands({ found }: { found: Candidate }) {
  const shown = Math.min(found.count, MOST);
  if (found.wiring !== "parallel") {
    const wide = 190 / shown;
    return <>{Array.from({ length: shown }, (_, k) => <Strand key={k} x={70 + k * wide} y={30} wide={wide} />)}</>;
  }
  const at = (k: number): number => 30 + (k - (shown - 1) / 2) * 14 + 7 * (shown - 1);
  return (
    <>
      <path d={`M70 30 V${at(shown - 1)} M260 30 V${at(shown - 1)}`} />
      {Array.from({ length: shown }, (_, k) => <Strand key={k} x={70} y={at(k)} wide={190} />)}
    </>
  );
}

/** What to buy for it, in words. */
function listParts(found: Candidate, supply: string): string[] {
  const { current, voltage, power } = found.drive ?? { current: 0, voltage: 0, power: 0 };
  const volts = Number.parseFloat(readComma(supply));
  const share = /^[\d.,]+\s*V?$/.test(supply.trim()) && volts >= voltage ? `, which a duty cycle of ${digits(100 * (voltage / volts) ** 2, 2)} % gives, if nothing else limits the current` : "";
  return [
    `Supply: ${supply}, at least ${digits(SPARE * current, 2)} A. The wires take ${digits(voltage, 3)} V and ${digits(current, 3)} A, ${digits(power, 3)} W, while they heat${share}.`,
    `Transistor: n-channel MOSFET at the ground side, driven by the logic level of the board, for ${digits(SPARE * current, 2)} A and above.`,
    `Fuse: ${digits(1.25 * current, 2)} A, slow, in case the transistor fails closed.`,
    `Wires: ${found.count} of ${found.size}${found.count > 1 ? `, in ${found.wiring}` : ""}, ${digits(found.strand_resistance, 3)} Ω each; crimped, not soldered.`,
  ];
}

export function Circuit({ found }: { found: Candidate }) {
  if (!found.drive || !found.wiring) return null;
  const supply = fields.value["supply"]?.trim() || "supply";
  const name = fileName(found).replace(".toml", "-loop.toml");
  return (
    <details class="size-circuit" open>
      <summary>Electronics and wiring</summary>
      <svg viewBox="0 0 340 130" role="img" aria-label={`Circuit: ${supply}, ${found.count} wires, a transistor to ground switched by the board`}>
        <path d="M20 50 V30 H70 M260 30 H290 V62 M290 92 V112 H20 V70" />
        <path d="M10 50 H30 M14 70 H26" class="circuit-thick" />
        <text x="36" y="64">{supply}</text>
        <Strands found={found} />
        {found.count > MOST && <text x="150" y="92">… {found.count} in all</text>}
        <path d="M278 62 V92 M282 62 V70 M282 74 V82 M282 86 V92 M282 66 H290 M282 89 H290 M262 77 H278" class="circuit-thick" />
        <text x="188" y="81">board (PWM)</text>
        <text x="298" y="81">FET</text>
        <path d="M144 112 V118 M136 118 H152 M139 121 H149 M142 124 H146" />
      </svg>
      <ul class="sentences">
        {listParts(found, supply).map((words) => (
          <li key={words}>{words}</li>
        ))}
        {found.loop && (
          <li>
            On a board: open it in a loop, tune it, save it, then <code>martensite export firmware {name} --board uno</code>.
          </li>
        )}
      </ul>
    </details>
  );
}
