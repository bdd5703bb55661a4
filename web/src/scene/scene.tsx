// The mechanism in space, at the time of the cursor.

import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { digits, toShown } from "../lib/numbers.ts";
import type { Run } from "../lib/types.ts";
import { palette } from "../lib/theme.ts";
import { Share } from "../share/share.tsx";
import { cursor, pinned, run } from "../state/run.ts";
import { Message } from "../ui/message.tsx";
import { findCuts } from "./cuts.ts";
import { Legend, told, Values } from "./legend.tsx";
import { Motion, valueAt } from "./motion.ts";
import { choosePaints, makeReader } from "./reading.ts";
import { toggle } from "./playing.ts";
import { Saving } from "./saving.tsx";
import { shownStage } from "./shown.ts";
import { Side } from "./side.tsx";
import { Toggles } from "./toggles.tsx";
import type { Reading, Stage, View } from "./stage.ts";
import { NAMES, type Quantity } from "./tint.ts";
import { grabbing, hand } from "../touch/live.ts";

const VIEWS: [View, string][] = [["free", "Fit"], ["front", "Front"], ["side", "Side"], ["top", "Top"]];
const MANY = 4;

/** Whether this browser was found to have no WebGL. */
let isFlat = false;

/** What the picture shows, in words. */
function described(now: Run, time: number, motion: Motion): string {
  const how = now.outputs[now.coordinate];
  const value = valueAt(now.times, now.columns[now.coordinate], time);
  const place = how ? `${how.long_name} ${digits(toShown(value, how))} ${how.display_unit}` : "";
  const ports = Object.keys(now.scene.ports);
  const elements = ports.length > MANY ? [`${ports.length} elements`] : ports.map((port) => `${port}: ${told(now, port, time, motion.slack(port, time))}`);
  return [`The mechanism at ${digits(time)} s`, place, ...elements].filter(Boolean).join("; ");
}

/** The run that was pinned last, if it is not the one that is shown. */
function ghostOf(now: Run): Run | null {
  const last = pinned.value.at(-1)?.run;
  return last && last !== now ? last : null;
}

export function Scene() {
  const now = run.value;
  if (!now?.scene) return null;
  if (now.scene.sentence) return <section class="panel scene" aria-label="Mechanism"><Message kind="note">{now.scene.sentence}</Message></section>;
  return <Shown now={now} />;
}

function Shown({ now }: { now: Run }) {
  const quantity = useSignal<Quantity>("temperature");
  const flat = useSignal(isFlat);
  const motion = useMemo(() => new Motion(now.scene), [now]);
  const read = useMemo(() => makeReader(now, quantity.value, motion), [now, quantity.value]);
  const broken = useMemo(() => findCuts([now.scene]).length > 0, [now]);
  const whole = useSignal(false);
  const stage = useRef<Stage | null>(null);
  const view = (name: View): void => stage.current?.fit(name);
  return (
    <section class="panel scene" aria-label="Mechanism">
      {flat.value ? (
        <>
          <Message kind="note">This browser has no WebGL: the mechanism is drawn from the side, not in space.</Message>
          <Flat now={now} motion={motion} read={read} />
        </>
      ) : (
        <div class="scene-frame">
          <Space now={now} motion={motion} read={read} stage={stage} whole={whole.value} lost={() => (flat.value = isFlat = true)} />
          <div class="scene-corner" role="group" aria-label="View">
            {VIEWS.map(([name, title]) => (
              <button key={name} type="button" onClick={() => view(name)}>
                {title}
              </button>
            ))}
          </div>
        </div>
      )}
      <div class="row scene-below">
        {!flat.value && <Toggles stage={stage} broken={broken} whole={whole.value} choose={(one) => (whole.value = one)} />}
        {!flat.value && <Saving run={now} ghost={ghostOf(now)} whole={whole.value} read={read} stage={stage} />}
        {!hand.value && <Share />}
        {motion.data.shapes.some((shape) => shape.port) && <Colours now={now} quantity={quantity.value} choose={(one) => (quantity.value = one)} />}
        <AtCursor now={now} motion={motion} />
      </div>
    </section>
  );
}

function Colours(props: { now: Run; quantity: Quantity; choose: (quantity: Quantity) => void }) {
  return (
    <div class="row scene-colours">
      <label class="small">
        Colour of elements{" "}
        <select value={props.quantity} onChange={(event) => props.choose(event.currentTarget.value as Quantity)}>
          {Object.entries(NAMES).map(([key, name]) => (
            <option key={key} value={key}>
              {name}
            </option>
          ))}
        </select>
      </label>
      <Legend run={props.now} quantity={props.quantity} />
    </div>
  );
}

function AtCursor({ now, motion }: { now: Run; motion: Motion }) {
  const time = cursor.value;
  return <Values run={now} time={time} slack={(port) => motion.slack(port, time)} />;
}

interface PictureProps {
  now: Run;
  motion: Motion;
  read: (time: number) => Reading;
}

function Flat({ now, read }: PictureProps) {
  const time = cursor.value;
  const motion = useMemo(() => new Motion(now.scene, findCuts([now.scene])), [now]);
  return <Side motion={motion} time={time} colour={read(time).colour} label={described(now, time, motion)} />;
}

/** Arrow keys turn, + and - come nearer and go back, 0 fits, space plays. */
function steered(stage: Stage, key: string): boolean {
  const moves: Record<string, [number, number, number]> = {
    ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0],
    "+": [0, 0, 1], "=": [0, 0, 1], "-": [0, 0, -1],
  };
  const move = moves[key];
  if (move) stage.nudge(...move);
  else if (key === "0") stage.fit();
  else if (key === " ") toggle();
  else return false;
  return true;
}

function Space(props: PictureProps & { stage: { current: Stage | null }; whole: boolean; lost: () => void }) {
  const { now, motion, read, stage, whole } = props;
  const host = useRef<HTMLDivElement>(null);
  const ready = useSignal(false);
  useEffect(() => made(host.current, stage, () => (ready.value = true), props.lost), []);
  const ghost = ghostOf(now);
  useEffect(() => stage.current?.show(now.scene, ghost?.scene, whole), [now, ghost, whole, ready.value]);
  useEffect(() => {
    return palette.subscribe((p) => stage.current?.paint(choosePaints(p)));
  }, [ready.value]);
  useEffect(() => {
    const leave = cursor.subscribe((time) => {
      stage.current?.put(time, read(time));
      host.current?.setAttribute("aria-label", described(now, time, motion));
    });
    return leave;
  }, [now, read, ghost, whole, ready.value]);
  useEffect(() => {
    if (stage.current) stage.current.grabbing = hand.value ? grabbing : null;
  }, [hand.value, ready.value]);
  const press = (event: KeyboardEvent): void => {
    if (stage.current && !event.ctrlKey && !event.metaKey && steered(stage.current, event.key)) event.preventDefault();
  };
  return (
    <div
      ref={host}
      class="scene-view"
      role="application"
      aria-roledescription="3-D view; arrow keys turn it, plus and minus zoom, 0 fits, space plays"
      tabIndex={0}
      onKeyDown={press}
      title="Drag to turn, wheel to zoom, right button to move; or arrow keys, + and -"
    >
      {!ready.value && <span class="scene-waiting soft">Loading …</span>}
    </div>
  );
}

/** After the next frame: the first curves do not wait for what draws in space. */
const painted = (): Promise<void> => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

/** Make the stage once its code is there; gives what ends it. */
function made(
  host: HTMLElement | null,
  stage: { current: Stage | null },
  ready: () => void,
  lost: () => void,
): () => void {
  let over = false;
  const watch = new ResizeObserver(() => stage.current?.resize());
  painted().then(() => import("./stage.ts")).then(
    ({ Stage }) => {
      if (over || !host) return;
      try {
        shownStage.current = stage.current = new Stage(host);
      } catch {
        return lost();
      }
      host.querySelector("canvas")?.addEventListener("webglcontextlost", () => over || lost());
      watch.observe(host);
      ready();
    },
    () => lost(),
  );
  return () => {
    over = true;
    watch.disconnect();
    stage.current?.dispose();
    shownStage.current = stage.current = null;
  };
}
