// Pictures of the doors: the device, or what its page answers, as a drawing.

import type { ComponentChildren } from "preact";

function Frame({ children }: { children: ComponentChildren }) {
  return (
    <svg class="door-picture" viewBox="0 0 240 120" aria-hidden="true">
      {children}
    </svg>
  );
}

/** Hatched ground from x to x at a height; hatching above or below. */
function Ground({ from, to, y, up = true }: { from: number; to: number; y: number; up?: boolean }) {
  const marks = Array.from({ length: Math.floor((to - from) / 8) }, (_, k) => from + 8 * k + 2);
  return (
    <g class="p-soft">
      <path d={`M${from} ${y}H${to}`} />
      {marks.map((x) => (
        <path key={x} d={up ? `M${x} ${y}l5 -6` : `M${x} ${y + 6}l5 -6`} />
      ))}
    </g>
  );
}

function Lift() {
  return (
    <Frame>
      <Ground from={62} to={178} y={16} />
      <path class="p-cold" d="M86 16V78" />
      <rect class="p-weight" x="72" y="78" width="28" height="28" rx="2" />
      <path class="p-hot" d="M154 16V54" />
      <rect class="p-weight" x="140" y="54" width="28" height="28" rx="2" />
      <path class="p-guide" d="M100 78H140M168 78H196M168 54H196" />
      <path class="p-arrow" d="M186 77V57M181 63l5 -7 5 7" />
    </Frame>
  );
}

/** The mechanism of the scenario behind the door: one joint, the wire below it, a return spring on a drum above it. */
function Finger() {
  return (
    <Frame>
      <path class="p-weight" d="M20 22H30V72H20z" />
      <path class="p-bone" d="M38 44H128" />
      <path class="p-bone" d="M128 44L163 94" />
      <path class="p-guide" d="M142 36H196M142 52H196" />
      <path class="p-soft" d="M62 38V30H67l3 -4 5 8 5 -8 5 8 5 -8 5 8 3 -4H128" />
      <path class="p-soft" d="M116 50V60M135 54L126 60" />
      <path class="p-hot" d="M52 58H116L126 60L148 91" />
      <g class="p-joint">
        <circle cx="128" cy="44" r="13" />
        <circle cx="128" cy="44" r="4" />
      </g>
      <path class="p-arrow" d="M202 48Q202 78 182 92M192 88l-10 5 3 -11" />
    </Frame>
  );
}

function Hold() {
  return (
    <Frame>
      <path class="p-soft" d="M30 12V104H222" />
      <path class="p-wish" d="M30 92H56V66H100V40H150V66H186V92H216" />
      <path class="p-curve" d="M30 92H58C64 70 66 64 74 66S88 66 100 66C106 46 110 38 116 40S136 40 150 40C158 40 162 62 168 65S178 66 186 66C196 66 200 84 216 91" />
      <circle class="p-dot" cx="130" cy="40" r="5" />
    </Frame>
  );
}

/** Readings about a loop, off it by what a table of fixed deviations says. */
const OFF = [2, -3, 1, -2, 3, -1, 2, -2];
const HEATED = [[48, 26], [72, 28], [96, 31], [118, 44], [132, 66], [146, 88], [172, 95], [198, 97]];
const COOLED = [[184, 96], [150, 93], [124, 88], [104, 70], [92, 50], [78, 33], [60, 28]];

function Log() {
  return (
    <Frame>
      <path class="p-soft" d="M30 12V104H222" />
      <path class="p-curve" d="M42 26C100 27 108 32 120 48S138 90 156 93 190 97 204 97" />
      <path class="p-curve cold" d="M204 97C160 96 130 95 114 82S92 34 74 30 50 26 42 26" />
      <g class="p-reading">
        {[...HEATED, ...COOLED].map(([x = 0, y = 0], k) => (
          <circle key={k} cx={x} cy={y + OFF[k % OFF.length]!} r="2.6" />
        ))}
      </g>
    </Frame>
  );
}

function Wire() {
  const spools = [52, 104, 156, 200];
  return (
    <Frame>
      <path class="p-fits" d="M92 10H126V110H92z" />
      {spools.map((x, k) => (
        <g key={x}>
          <path class={k === 1 ? "p-hot" : "p-cold"} style={{ strokeWidth: `${1.5 + 1.8 * k}px` }} d={`M${x + 5} 18V84`} />
          <circle class="p-soft" cx={x + 5} cy={98} r={1.2 + 1.6 * k} />
        </g>
      ))}
      <path class="p-tick" d="M114 50l6 7 11 -15" transform="translate(8 0)" />
    </Frame>
  );
}

function Paper() {
  return (
    <Frame>
      <path class="p-sheet" d="M58 8H134L152 26V112H58z" />
      <path class="p-soft" d="M134 8V26H152" />
      <path class="p-text" d="M70 22H122M70 32H138M70 92H138M70 101H118" />
      <path class="p-soft" d="M72 42V82H138" />
      <path class="p-curve" d="M76 78C94 78 98 74 104 62S116 47 134 46" />
      <path class="p-guide" d="M172 8V112" />
      <path class="p-curve cold" d="M182 78C196 78 200 74 204 63S212 48 226 46" />
      <path class="p-tick" d="M192 96l6 7 12 -16" />
    </Frame>
  );
}

/** A map of a result over two numbers: stronger to the upper right, with a ridge. */
function Sweep() {
  const cells = Array.from({ length: 40 }, (_, k) => ({ x: k % 8, y: Math.floor(k / 8) }));
  return (
    <Frame>
      {cells.map(({ x, y }) => (
        <rect key={`${x} ${y}`} class="p-cell" x={48 + 18 * x} y={8 + 18 * (4 - y)} width="16" height="16" opacity={0.12 + 0.88 * Math.exp(-(((x - 5) / 3) ** 2) - ((y - 3) / 2) ** 2)} />
      ))}
      <path class="p-soft" d="M42 6V102H194" />
    </Frame>
  );
}

export const PICTURES: Record<string, () => ComponentChildren> = { lift: Lift, finger: Finger, hold: Hold, log: Log, wire: Wire, paper: Paper, sweep: Sweep };
