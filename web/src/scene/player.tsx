// Time: play and pause, one sample on or back, any time by the slider, and how fast.

import { useEffect } from "preact/hooks";
import { digits } from "../lib/numbers.ts";
import type { Alarm, Run } from "../lib/types.ts";
import { cursor, run } from "../state/run.ts";
import { LiveButton } from "../touch/panel.tsx";
import { hand } from "../touch/live.ts";
import { begin, end, fitting, goTo, loops, pause, playing, SPEEDS, speed, step, toggle } from "./playing.ts";

export function Player() {
  const now = run.value;
  useEffect(() => pause, []);
  if (hand.value) return <Pacing />;
  if (!now || now.times.length < 2) return null;
  const press = (event: KeyboardEvent): void => {
    if (event.key !== " " || event.target instanceof HTMLButtonElement || event.target instanceof HTMLSelectElement) return;
    if (event.target instanceof HTMLInputElement && event.target.type === "checkbox") return;
    event.preventDefault();
    toggle();
  };
  const name = playing.value ? "Pause" : "Play";
  return (
    <div class="panel player" role="group" aria-label="Time" onKeyDown={press}>
      <button type="button" class="main player-play" aria-label={name} title={`${name} (space)`} onClick={toggle}>
        {playing.value ? "⏸︎" : "▶︎"}
      </button>
      <LiveButton />
      <button type="button" aria-label="One sample back" title="One sample back" onClick={() => step(-1)}>
        ‹
      </button>
      <button type="button" aria-label="One sample on" title="One sample on" onClick={() => step(1)}>
        ›
      </button>
      <Scrub now={now} />
      <output class="player-time">
        {told(cursor.value, end.value)} / {digits(end.value)} s
      </output>
      <Pace />
    </div>
  );
}

/** While the model runs by hand: what stops it, and how fast it goes. */
function Pacing() {
  return (
    <div class="panel player" role="group" aria-label="Time">
      <LiveButton />
      <output class="player-time">{cursor.value.toFixed(1)} s</output>
      <span class="player-scrub" />
      <Pace />
    </div>
  );
}

/** A time with as many decimals as its end asks for, so that digits stand still. */
function told(time: number, last: number): string {
  const decimals = Math.min(Math.max(2 - Math.floor(Math.log10(last || 1)), 0), 6);
  return time.toFixed(decimals);
}

function Scrub({ now }: { now: Run }) {
  const arrows = (event: KeyboardEvent): void => {
    const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    step(by);
  };
  return (
    <div class="player-scrub">
      <Marks now={now} />
      <input
        type="range"
        aria-label="Time"
        aria-valuetext={`${told(cursor.value, end.value)} s`}
        min={begin.value}
        max={end.value}
        step="any"
        value={cursor.value}
        onInput={(event) => goTo(event.currentTarget.valueAsNumber)}
        onKeyDown={arrows}
      />
    </div>
  );
}

/** Where alarms occur: the sentences are those above the pictures. */
function Marks({ now }: { now: Run }) {
  const width = end.value - begin.value || 1;
  const share = (time: number): number => (100 * (time - begin.value)) / width;
  const marks = now.alarms.flatMap((alarm) => spans(alarm).map((span) => ({ alarm, span })));
  return (
    <div class="player-marks" aria-hidden="true">
      {marks.map(({ alarm, span: [first, last] }, k) => (
        <i
          key={k}
          class={`player-mark ${alarm.kind}`}
          title={alarm.sentence ?? alarm.kind}
          style={{ left: `${share(first)}%`, width: `${Math.max(share(last) - share(first), 0)}%` }}
        />
      ))}
    </div>
  );
}

const spans = (alarm: Alarm): [number, number][] => alarm.spans ?? [[alarm.first, alarm.first + alarm.duration]];

function Pace() {
  const choose = (event: Event): void => {
    const { value } = event.currentTarget as HTMLSelectElement;
    speed.value = value === "fit" ? "fit" : Number(value);
  };
  return (
    <>
      <label class="small player-speed" title="Speed">
        <span class="hidden">Speed</span>
        <select value={String(speed.value)} onChange={choose}>
          <option value="fit" title="the whole run in 8 s">auto, {digits(fitting.value, 2)}×</option>
          {SPEEDS.map((one) => (
            <option key={one} value={one}>
              {one}×
            </option>
          ))}
        </select>
      </label>
      {!hand.value && (
        <label class="small player-loop">
          <input type="checkbox" checked={loops.value} onChange={(event) => (loops.value = event.currentTarget.checked)} /> Loop
        </label>
      )}
    </>
  );
}
