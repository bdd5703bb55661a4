// The bench: the scenario's numbers at the left, what comes of them at the right.

import { computed, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Busy, busy } from "../bench/busy.tsx";
import { Danger } from "../bench/danger.tsx";
import { Insight } from "../bench/insight.tsx";
import { Measures } from "../bench/measures.tsx";
import { Controls } from "../form/controls.tsx";
import { Documents } from "../form/documents.tsx";
import { onTop } from "../form/pinned.ts";
import { refusals } from "../form/state.ts";
import { call } from "../lib/api.ts";
import { Charts, Planes } from "../plots/charts.tsx";
import { Compare } from "../plots/compare.tsx";
import { Warnings } from "../plots/warnings.tsx";
import { Player } from "../scene/player.tsx";
import { Scene } from "../scene/scene.tsx";
import { place, readPlace } from "../state/route.ts";
import { tellRefusal } from "../lib/refusal.ts";
import { computing, followDocument, followWaiting, refused, run } from "../state/run.ts";
import { broken, change, followInAddress, fromAddress, text } from "../state/scenario.ts";
import { hand } from "../touch/live.ts";
import { LivePanel } from "../touch/panel.tsx";
import { ChallengeResult } from "../touch/result.tsx";
import { BrokenLink } from "../ui/broken-link.tsx";
import { Message } from "../ui/message.tsx";

const FIRST = "dead_weight";

interface Listed {
  scenarios: { name: string; title: string; text: string }[];
}

/** Begin with the scenario of the address, with what was on the bench, or with the first one. */
async function begin(): Promise<void> {
  if ((await fromAddress()) || text.value) return;
  await beginFirst(() => !text.value && !readPlace().query.has("scenario"));
}

/** Put the first scenario there, unless something else has come meanwhile. */
async function beginFirst(isWanted = (): boolean => true): Promise<void> {
  const { scenarios } = await call<Listed>("scenarios");
  if (!isWanted()) return;
  const first = scenarios.find((one) => one.name === FIRST) ?? scenarios[0];
  if (first) change(first.text);
}

/** Whether a field in sight tells why it was refused. */
const toldBeside = computed(() => onTop.value.some((node) => refusals.value[node.path] === refused.value));

function Title() {
  const now = run.value;
  const open = useSignal(false);
  const effort = now && (hand.value ? "running by hand" : `${now.samples} samples, ${now.steps} steps in ${(now.seconds * 1000).toFixed(0)} ms`);
  const about = now ? `${now.described}; ${effort}` : "";
  return (
    <div class="bench-title">
      <h1>
        {now?.title ?? "Bench"}
        {now && busy.value && <span class="soft"> (previous run)</span>}
      </h1>
      {now && (
        <button type="button" class="quiet info" aria-expanded={open.value} aria-controls="bench-described" aria-label="About this run" title={about} onClick={() => (open.value = !open.value)}>
          <span aria-hidden="true">i</span>
        </button>
      )}
      <p id="bench-described" class="soft small" hidden={!open.value}>
        {about}
      </p>
    </div>
  );
}

/** Bring the sliders of the sheet into view, and the numbers that they change above it. */
function showBoth(): void {
  for (const name of [".top-controls", ".measures"]) document.querySelector(name)?.scrollIntoView({ block: "start" });
}

export function Page() {
  useEffect(() => {
    const leave = [followDocument(), followInAddress(), followWaiting()];
    return () => leave.forEach((end) => end());
  }, []);
  useEffect(() => void begin(), [place.value]);
  const sheet = useSignal(false);
  const flip = (): void => {
    sheet.value = !sheet.value;
    if (sheet.value) requestAnimationFrame(showBoth);
  };
  if (broken.value) return <BrokenLink onFirst={() => void beginFirst()} />;
  return (
    <div class={`bench ${sheet.value ? "with-sheet" : ""} ${busy.value ? "stale" : ""}`} aria-busy={computing}>
      <section class="bench-controls stack" id="bench-controls" aria-label="Scenario">
        <Documents />
        <Controls />
      </section>
      <section class="bench-results stack" aria-label="Results">
        <div class="bench-head">
          <Title />
          {!hand.value && <Compare />}
        </div>
        <Busy />
        {refused.value && <Message kind="error">{toldBeside.value ? "The value was refused; the reason is beside its field." : tellRefusal(refused.value)}{run.value && " The previous run is shown."}</Message>}
        {hand.value ? (
          <LivePanel />
        ) : (
          <>
            <ChallengeResult />
            <Measures />
            <Danger />
            <Insight />
            <Warnings />
          </>
        )}
        <div class="bench-view">
          <div class="stack bench-space">
            <Scene />
            <Player />
          </div>
          <Planes />
        </div>
        {!hand.value && <Charts />}
      </section>
      <div class="bench-bar">
        <button type="button" class="main" aria-expanded={sheet.value} aria-controls="bench-controls" onClick={flip}>
          {sheet.value ? "Close controls" : "Change something …"}
        </button>
      </div>
    </div>
  );
}
