// Running by hand: the button, what is held, and how strongly.

import { useEffect, useLayoutEffect } from "preact/hooks";
import { digits, toShown } from "../lib/numbers.ts";
import { printed } from "../plots/drawn.ts";
import { run } from "../state/run.ts";
import { Message } from "../ui/message.tsx";
import { beginChallenge, canChallenge, challenge, GRACE, LENGTH } from "./challenge.ts";
import { beginLive, giveShare, hand, preparing, said, setLoad, stopLive, setStrength, turned, type Hand, type Source } from "./live.ts";
import { chooseTarget } from "./score.ts";
import { Strip } from "./strip.tsx";

/** A hundred places are enough for a slider. */
const PLACES = 100;
const KEY = "h";

export function LiveButton() {
  const on = hand.value !== null;
  const title = on ? "Pause; the recording stays as a run that you can pin and save" : "Run by hand: hold to heat, drag the load, watch the loop grow";
  return (
    <>
      <button type="button" class={`live-button ${on ? "main" : ""}`} aria-pressed={on} title={title} disabled={preparing.value} onClick={() => (on ? stopLive() : void beginLive())}>
        {on ? "Pause" : preparing.value ? "Preparing …" : "Live"}
      </button>
      {!on && said.value && <Message kind="error">{said.value}</Message>}
    </>
  );
}

const inField = (target: EventTarget | null): boolean =>
  target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && target.type !== "range");

/** The first drive by a key, anywhere on the page; everything is let go when the page is left. */
function follow(): () => void {
  const key = (event: KeyboardEvent): void => {
    if (event.key.toLowerCase() !== KEY || event.ctrlKey || event.metaKey || event.altKey || inField(event.target)) return;
    event.preventDefault();
    giveShare(0, event.type === "keydown" ? 1 : 0);
  };
  const release = (): void => hand.peek()?.drives.forEach((_, k) => giveShare(k, 0));
  const hidden = (): void => void (document.hidden && stopLive());
  addEventListener("keydown", key);
  addEventListener("keyup", key);
  addEventListener("blur", release);
  document.addEventListener("visibilitychange", hidden);
  return () => {
    removeEventListener("keydown", key);
    removeEventListener("keyup", key);
    removeEventListener("blur", release);
    document.removeEventListener("visibilitychange", hidden);
  };
}

export function LivePanel() {
  useLayoutEffect(follow, []); // a key may come before the first picture
  useEffect(() => stop, []);
  const now = hand.value;
  if (!now) return null;
  return (
    <section class="panel live" aria-label="Running by hand">
      <div class="live-row">
        {now.drives.map((one, k) =>
          one.kind === "heat" ? (
            <Drive key={one.drive.name} one={one} k={k} alone={now.drives.length === 1} turn={turned.value} />
          ) : (
            one.kind === "setpoint" && (
              <Slider key={one.drive.name} words="Set point" value={one.strength} how={one.drive.how} high={one.most} put={(value) => setStrength(k, value)} />
            )
          ),
        )}
        {now.load && <Slider {...now.load} put={setLoad} />}
        {canChallenge(now) && <ChallengeButton />}
      </div>
      <Goal now={now} turn={turned.value} />
      <p class="soft small">{describeHand(now)}</p>
      {said.value && <Message kind="caution">{said.value}</Message>}
    </section>
  );
}

/** What can be done with what is run. */
function describeHand({ drives, load }: Hand): string {
  if (drives.some(({ kind }) => kind === "setpoint")) {
    return `The controller holds the set point. ${load ? `Drag the ${load.shapes[0]} in the picture to pull at the wire: the controller changes its heat.` : ""}`;
  }
  return `Hold to heat, release to cool. ${load ? `Drag the ${load.shapes[0]} in the picture to change the load, or drag` : "Drag"} the point of the phase diagram.`;
}

/** The position that a controller or a hand should hold, over the last seconds. */
function Goal({ now }: { now: Hand; turn: number }) {
  const shown = run.value;
  const own = challenge.value;
  const wish = now.drives.find(({ kind, drive }) => kind === "setpoint" && drive.how.unit === shown?.outputs[shown.coordinate]?.unit);
  if (!shown || (!own && !wish)) return null;
  return <Strip recording={now.recording} now={shown} target={own ? own.target.at : wish!.strength} band={own?.target.band ?? 0} />;
}

function ChallengeButton() {
  const own = challenge.value;
  if (own) {
    const words = own.gone < 0 ? `Reach ${own.target.words}: ${Math.ceil(-own.gone)} s` : `Hold ${own.target.words}: ${Math.ceil(LENGTH - own.gone)} s`;
    return (
      <output class="live-countdown">
        <strong>{words}</strong>
      </output>
    );
  }
  const target = chooseTarget(hand.value!.recording.before);
  return (
    <button type="button" title={`${GRACE} s to get there, then ${LENGTH} s count`} onClick={beginChallenge}>
      Challenge: hold {target?.words} by hand
    </button>
  );
}

interface Spelled {
  display_unit: string;
  factor: number;
  offset: number;
}

const spell = (value: number, how: Spelled): string => `${digits(toShown(value, how), 3)} ${printed(how.display_unit === "1" ? "" : how.display_unit)}`;

/** `turn` counts changes of what is held: the drive itself stays the same object. */
function Drive({ one, k, alone }: { one: Source; k: number; alone: boolean; turn: number }) {
  const { drive, strength, most, share } = one;
  const name = drive.port ? (alone ? "Heat" : `Heat ${drive.port.replaceAll("_", " ")}`) : drive.name;
  const press = (event: PointerEvent): void => {
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    giveShare(k, 1);
  };
  const key = (event: KeyboardEvent): void => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    giveShare(k, event.type === "keydown" ? 1 : 0);
  };
  const let_go = (): void => giveShare(k, 0);
  return (
    <div class="live-drive">
      <button
        type="button"
        class={`live-heat ${share > 0 ? "on" : ""}`}
        aria-pressed={share > 0}
        title={k === 0 ? `Hold the button, or the key ${KEY.toUpperCase()}` : "Hold the button"}
        style={{ "--share": `${100 * share}%` }}
        onPointerDown={press}
        onPointerUp={let_go}
        onPointerCancel={let_go}
        onKeyDown={key}
        onKeyUp={key}
        onBlur={let_go}
        onContextMenu={(event) => event.preventDefault()}
      >
        {name}
      </button>
      <label class="small">
        {spell(strength, drive.how)}
        <input
          type="range"
          aria-label={`${name}: level while it is held`}
          aria-valuetext={spell(strength, drive.how)}
          min={0}
          max={most}
          step={most / PLACES}
          value={strength}
          onInput={(event) => setStrength(k, event.currentTarget.valueAsNumber)}
        />
      </label>
    </div>
  );
}

function Slider({ words, value, how, low = 0, high, put }: { words: string; value: number; how: Spelled; low?: number; high: number; put: (value: number) => void }) {
  return (
    <label class="small live-load">
      {words}: {spell(value, how)}
      <input
        type="range"
        aria-label={words}
        aria-valuetext={spell(value, how)}
        min={low}
        max={high}
        step={(high - low) / PLACES}
        value={value}
        onInput={(event) => put(event.currentTarget.valueAsNumber)}
      />
    </label>
  );
}
